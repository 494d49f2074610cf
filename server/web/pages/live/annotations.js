// The learner's annotations of the steps of an enlarged environment.

import { annotationView } from "../elements/annotations.js";

const STEPS_SHOWN = 300;

export class AnnotationView {
  #list;
  #actions;
  #views = new Map();  // name -> { view, points: [step, value] of a line }
  #last = null;        // the last step
  #time = 0;           // steps since the view was opened

  // `list`: where to draw; `actions`: the catalog's.
  constructor(list, actions) {
    this.#list = list;
    this.#actions = actions;
    list.replaceChildren();
    list.hidden = true;
  }

  // Adds the annotations of a step. Frames may skip steps, and show some again.
  add(step, annotations) {
    if (step.action === null || this.#isShown(step)) {
      return;
    }
    const isSameEpisode = this.#last && this.#last.length < step.length;
    this.#time += isSameEpisode ? step.length - this.#last.length : step.length;
    this.#last = step;
    for (const { name, values } of annotations) {
      const shown = this.#viewOf(name, values.length);
      if (values.length === 1) {
        const from = this.#time - STEPS_SHOWN;
        shown.points = [...shown.points.filter(([time]) => time > from), [this.#time, values[0]]];
        shown.view.draw(shown.points, from, this.#time);
      }
      shown.view.show(values, this.#time);
    }
    this.#list.hidden = this.#views.size === 0;
  }

  #isShown({ length, return: sum, levelSeed: seed }) {
    return this.#last?.length === length && this.#last.return === sum && this.#last.levelSeed === seed;
  }

  // The view of a name. Another number of values begins a new one.
  #viewOf(name, count) {
    const old = this.#views.get(name);
    if (old?.view.count === count) {
      return old;
    }
    old?.view.panel.remove();
    const shown = { view: annotationView(name, count, this.#actions), points: [] };
    this.#views.set(name, shown);
    this.#list.append(shown.view.panel);
    return shown;
  }
}
