// The learner's annotations along the time line of a replay: one value as a line, several as bars of the shown step.

import { Bars, labelsOf } from "../elements/bars.js";
import { element, setText } from "../elements/elements.js";
import { significant } from "../elements/figures.js";

const HEIGHT = 100;  // of a line's drawing, in its own units
const SVG = "http://www.w3.org/2000/svg";

export class AnnotationTracks {
  #lines;
  #bars;
  #onSeek;
  #tracks = [];  // { name, view, valuesOf(row) }

  // `lines`, `bars`: where to draw; `onSeek(fraction)` is called when a part of a line is pressed, in [0, 1].
  constructor(lines, bars, onSeek) {
    this.#lines = lines;
    this.#bars = bars;
    this.#onSeek = onSeek;
  }

  // Shows the annotations of a replay. `actions`: the catalog's.
  open(replay, frames, actions) {
    const { annotations, rowOfStep } = replay.source;
    this.#tracks = annotations.map((series) => {
      const values = valuesByRow(series, rowOfStep);
      const view = series.valueCount === 1 ? new Track(series.name, values, frames, this.#onSeek)
        : new Bars(series.name, labelsOf(series.name, series.valueCount, actions));
      return { name: series.name, view, valuesOf: (row) => values.get(row) ?? new Array(series.valueCount).fill(null) };
    });
    const panels = (isLine) => this.#tracks.filter(({ view }) => view instanceof Track === isLine).map(({ view }) => view.panel);
    this.#lines.replaceChildren(...panels(true));
    this.#bars.replaceChildren(...panels(false));
    this.#lines.hidden = this.#lines.childElementCount === 0;
    this.#bars.hidden = this.#bars.childElementCount === 0;
  }

  // The values at some rows, as texts: [{ name, texts }].
  textsOf(rows) {
    return this.#tracks.map(({ name, valuesOf }) => ({ name, texts: rows.map((row) => valuesOf(row).map(significant).join(" ")) }));
  }

  // Shows the values of the step that led to a row, at a frame.
  show(row, frame) {
    this.#tracks.forEach(({ view, valuesOf }) => view.add(valuesOf(row), frame));
  }
}

// The values of a series by the row that their step led to; null in place of those that are not finite.
function valuesByRow({ valueCount, firstStep, values }, rowOfStep) {
  const rows = Array.from({ length: values.length / valueCount }, (_, i) => i);
  return new Map(rows.map((i) => [
    rowOfStep(firstStep + i),
    values.slice(i * valueCount, (i + 1) * valueCount).map((value) => (Number.isFinite(value) ? value : null)),
  ]));
}

// A line over all frames, with a mark at the shown one.
class Track {
  #value = element("span", { class: "number" });
  #mark = document.createElementNS(SVG, "path");

  constructor(name, values, frames, onSeek) {
    const known = [...values].filter(([, [value]]) => value !== null);
    const low = known.reduce((least, [, [value]]) => Math.min(least, value), Infinity);
    const high = known.reduce((most, [, [value]]) => Math.max(most, value), -Infinity);
    const y = (value) => HEIGHT - (high > low ? (value - low) / (high - low) : 0.5) * HEIGHT;
    const line = document.createElementNS(SVG, "path");
    line.setAttribute("d", known.map(([row, [value]], i) => `${i === 0 ? "M" : "L"}${frames.ofRow(row)} ${y(value).toFixed(1)}`).join(""));
    this.#mark.setAttribute("class", "now");
    const drawing = document.createElementNS(SVG, "svg");
    drawing.setAttribute("viewBox", `0 0 ${Math.max(1, frames.last)} ${HEIGHT}`);
    drawing.setAttribute("preserveAspectRatio", "none");
    drawing.setAttribute("aria-hidden", "true");
    drawing.append(line, this.#mark);
    drawing.addEventListener("pointerdown", ({ clientX }) => {
      const { left, width } = drawing.getBoundingClientRect();
      onSeek((clientX - left) / width);
    });
    const range = known.length === 0 ? "" : `${significant(low)} to ${significant(high)}`;
    this.panel = element("section", { class: "annotation" },
      element("h3", {}, name, " ", this.#value, " ", element("span", { class: "quiet small number" }, range)), drawing);
  }

  add([value], frame) {
    setText(this.#value, significant(value));
    this.#mark.setAttribute("d", `M${frame} 0V${HEIGHT}`);
  }
}
