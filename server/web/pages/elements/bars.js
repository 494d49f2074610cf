// Several values of a step as bars.

import { element, setText } from "./elements.js";
import { significant } from "./figures.js";

const ACTION_PROBABILITIES = "action_probabilities";

// The labels of the values of a name: those of the catalog's actions, or numbers.
export function labelsOf(name, count, actions) {
  const isOfActions = name === ACTION_PROBABILITIES && count === actions.length;
  return Array.from({ length: count }, (_, i) => (isOfActions ? actions[i].name : String(i)));
}

export class Bars {
  #rows;

  constructor(name, labels) {
    this.count = labels.length;
    this.#rows = labels.map((label) => element("li", {}, element("span", {}, label), element("i"), element("span", { class: "number" })));
    this.panel = element("section", { class: "annotation" }, element("h3", {}, name), element("ol", { class: "bars" }, ...this.#rows));
  }

  // Probabilities are drawn relative to 1, other values relative to the largest.
  add(values) {
    const known = values.filter((each) => each !== null);
    const areShares = known.every((each) => each >= 0 && each <= 1);
    const most = areShares ? 1 : Math.max(...known.map(Math.abs));
    values.forEach((value, i) => {
      const [, bar, number] = this.#rows[i].children;
      bar.style.setProperty("--share", value === null ? 0 : Math.abs(value) / most);
      bar.classList.toggle("negative", value < 0);
      setText(number, significant(value));
    });
  }
}
