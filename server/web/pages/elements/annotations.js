// Values that a learner sends along with its steps: one as a line, several as bars, saliency as a map over the agent's view.

import { element, setText } from "./elements.js";
import { significant } from "./figures.js";

const HEIGHT = 100;  // of a line's drawing, in its own units
const ALPHA_MAX = 200;  // of 255, of a map
const GAIN = [255, 80, 0];  // colours of positive and of negative values of a map
const LOSS = [0, 120, 255];

// A view has a `panel`, the `count` of its values, and show(values, x). `onSeek(x)` is called when a line is pressed.
/** @returns {any} */
export function annotationView(name, count, actions, onSeek = () => {}) {
  return count === 1 ? new Line(name, onSeek) : new Bars(name, labelsOf(name, count, actions));
}

// The labels of the values of a name: those of the catalog's actions, or numbers.
function labelsOf(name, count, actions) {
  const isOfActions = name === "action_probabilities" && count === actions.length;
  return Array.from({ length: count }, (_, i) => (isOfActions ? actions[i].name : String(i)));
}

function drawingOf(name) {
  return document.createElementNS("http://www.w3.org/2000/svg", name);
}

class Line {
  count = 1;
  #value = element("span", { class: "number" });
  #range = element("span", { class: "quiet small number" });
  #drawing = drawingOf("svg");
  #path = drawingOf("path");
  #mark = drawingOf("path");

  constructor(name, onSeek) {
    this.#mark.setAttribute("class", "now");
    this.#drawing.setAttribute("preserveAspectRatio", "none");
    this.#drawing.setAttribute("aria-hidden", "true");
    this.#drawing.append(this.#path, this.#mark);
    this.#drawing.addEventListener("pointerdown", ({ clientX }) => {
      const { left, width } = this.#drawing.getBoundingClientRect();
      const { x, width: span } = this.#drawing.viewBox.baseVal;
      onSeek(x + (clientX - left) / width * span);
    });
    this.panel = element("section", { class: "annotation" }, element("h3", {}, name, " ", this.#value, " ", this.#range), this.#drawing);
  }

  // Draws points [x, value] for x in [from, to]. Null is a gap.
  draw(points, from, to) {
    const known = points.map(([, value]) => value).filter((value) => value !== null);
    const low = known.reduce((least, value) => Math.min(least, value), Infinity);
    const high = known.reduce((most, value) => Math.max(most, value), -Infinity);
    const y = (value) => HEIGHT - (high > low ? (value - low) / (high - low) : 0.5) * HEIGHT;
    let command = "M";
    const parts = points.map(([x, value]) => {
      const part = value === null ? "" : `${command}${x} ${y(value).toFixed(1)}`;
      command = value === null ? "M" : "L";
      return part;
    });
    this.#path.setAttribute("d", parts.join(""));
    this.#drawing.setAttribute("viewBox", `${from} 0 ${Math.max(1, to - from)} ${HEIGHT}`);
    setText(this.#range, known.length === 0 ? "" : `${significant(low)} to ${significant(high)}`);
  }

  show([value], x) {
    setText(this.#value, significant(value));
    this.#mark.setAttribute("d", `M${x} 0V${HEIGHT}`);
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
  show(values) {
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

// Splits the annotations of a step, [{ name, values }], into the saliency map, if any, and the others.
export function splitSaliency(annotations) {
  const isMap = ({ name, values }) => name === "saliency" && Number.isInteger(Math.sqrt(values.length));
  return { map: annotations.find(isMap)?.values ?? null, others: annotations.filter((each) => !isMap(each)) };
}

// Draws a map, row by row from the top, on a canvas over the agent's view; null hides it.
export function drawSaliency(canvas, map) {
  canvas.hidden = map === null;
  if (map === null) {
    return;
  }
  const side = Math.sqrt(map.length);
  const most = map.reduce((largest, value) => Math.max(largest, Math.abs(value)), 0) || 1;
  const drawing = new ImageData(side, side);
  map.forEach((value, i) => drawing.data.set([...(value < 0 ? LOSS : GAIN), ALPHA_MAX * Math.abs(value) / most], 4 * i));
  canvas.width = side;
  canvas.height = side;
  canvas.getContext("2d").putImageData(drawing, 0, 0);
}
