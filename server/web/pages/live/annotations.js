// What the learner sent along with its steps (annotations): one value as a line over the last steps, several as bars.

import { Bars, labelsOf } from "../elements/bars.js";
import { element, setText } from "../elements/elements.js";
import { significant } from "../elements/figures.js";

const STEPS_SHOWN = 300;
const HEIGHT = 100;  // of a line's drawing, in its own units
const SVG = "http://www.w3.org/2000/svg";

export class AnnotationView {
  #list;
  #actions;
  #views = new Map();  // name -> Line or Bars
  #last = null;        // the last step
  #time = 0;           // steps since the view was opened

  // `list`: where to draw; `actions`: the catalog's.
  constructor(list, actions) {
    this.#list = list;
    this.#actions = actions;
    list.replaceChildren();
    list.hidden = true;
  }

  // Adds the step of a frame. Frames may skip steps, and show some again.
  add(step) {
    if (!step || step.action === null || this.#isShown(step)) {
      return;
    }
    const isSameEpisode = this.#last && this.#last.length < step.length;
    this.#time += isSameEpisode ? step.length - this.#last.length : step.length;
    this.#last = step;
    for (const { name, values } of step.annotations) {
      this.#viewOf(name, values.length).add(values, this.#time);
    }
    this.#list.hidden = this.#views.size === 0;
  }

  #isShown({ length, return: sum, levelSeed: seed }) {
    return this.#last?.length === length && this.#last.return === sum && this.#last.levelSeed === seed;
  }

  // The view of a name. Another number of values begins a new one.
  #viewOf(name, count) {
    let view = this.#views.get(name);
    if (view?.count !== count) {
      view?.panel.remove();
      view = count === 1 ? new Line(name) : new Bars(name, labelsOf(name, count, this.#actions));
      this.#views.set(name, view);
      this.#list.append(view.panel);
    }
    return view;
  }
}

class Line {
  count = 1;
  #points = [];  // [step, value]
  #value = element("span", { class: "number" });
  #range = element("p", { class: "quiet small number" });
  #path = document.createElementNS(SVG, "path");

  constructor(name) {
    const drawing = document.createElementNS(SVG, "svg");
    drawing.setAttribute("viewBox", `0 0 ${STEPS_SHOWN} ${HEIGHT}`);
    drawing.setAttribute("preserveAspectRatio", "none");
    drawing.setAttribute("aria-hidden", "true");
    drawing.append(this.#path);
    this.panel = element("section", { class: "annotation" }, element("h3", {}, name, " ", this.#value), drawing, this.#range);
  }

  add([value], time) {
    this.#points = [...this.#points.filter(([step]) => step > time - STEPS_SHOWN), [time, value]];
    const known = this.#points.map(([, each]) => each).filter((each) => each !== null);
    const [low, high] = [Math.min(...known), Math.max(...known)];
    setText(this.#value, significant(value));
    setText(this.#range, known.length === 0 ? "" : `${significant(low)} to ${significant(high)} in the last ${STEPS_SHOWN} steps`);
    const y = (each) => HEIGHT - (high > low ? (each - low) / (high - low) : 0.5) * HEIGHT;
    let isGap = true;
    const parts = this.#points.map(([step, each]) => {
      const command = isGap ? "M" : "L";
      isGap = each === null;
      return isGap ? "" : `${command}${STEPS_SHOWN - (time - step)} ${y(each).toFixed(1)}`;
    });
    this.#path.setAttribute("d", parts.join(""));
  }
}
