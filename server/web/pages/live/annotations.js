// What the learner sent along with its steps (annotations): one value as a line over the last steps, several as bars.

import { element, setText } from "../elements/elements.js";
import { NONE } from "../elements/figures.js";

const STEPS_SHOWN = 300;
const HEIGHT = 100;  // of a line's drawing, in its own units
const SVG = "http://www.w3.org/2000/svg";
const ACTION_PROBABILITIES = "action_probabilities";

const digits = new Intl.NumberFormat("en", { maximumSignificantDigits: 3 });

function text(value) {
  return value === null ? NONE : digits.format(value);
}

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
      this.#viewOf(name, values.length).add(this.#time, values);
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
      view = count === 1 ? new Line(name) : new Bars(name, this.#labels(name, count));
      this.#views.set(name, view);
      this.#list.append(view.panel);
    }
    return view;
  }

  #labels(name, count) {
    const isOfActions = name === ACTION_PROBABILITIES && count === this.#actions.length;
    return Array.from({ length: count }, (_, i) => (isOfActions ? this.#actions[i].name : String(i)));
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

  add(time, [value]) {
    this.#points = [...this.#points.filter(([step]) => step > time - STEPS_SHOWN), [time, value]];
    const known = this.#points.map(([, each]) => each).filter((each) => each !== null);
    const [low, high] = [Math.min(...known), Math.max(...known)];
    setText(this.#value, text(value));
    setText(this.#range, known.length === 0 ? "" : `${text(low)} to ${text(high)} in the last ${STEPS_SHOWN} steps`);
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

class Bars {
  #rows;

  constructor(name, labels) {
    this.count = labels.length;
    this.#rows = labels.map((label) => element("li", {}, element("span", {}, label), element("i"), element("span", { class: "number" })));
    this.panel = element("section", { class: "annotation" }, element("h3", {}, name), element("ol", { class: "bars" }, ...this.#rows));
  }

  // Probabilities are drawn relative to 1, other values relative to the largest.
  add(time, values) {
    const known = values.filter((each) => each !== null);
    const areShares = known.every((each) => each >= 0 && each <= 1);
    const most = areShares ? 1 : Math.max(...known.map(Math.abs));
    values.forEach((value, i) => {
      const [, bar, number] = this.#rows[i].children;
      bar.style.setProperty("--share", value === null ? 0 : Math.abs(value) / most);
      bar.classList.toggle("negative", value < 0);
      setText(number, text(value));
    });
  }
}
