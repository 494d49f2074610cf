// The learner's annotations along the time line of a replay: one value as a line, several as bars of the shown step, saliency as a
// map.

import { annotationView, drawSaliency, splitSaliency } from "../elements/annotations.js";
import { byId } from "../elements/elements.js";
import { significant } from "../elements/figures.js";

export class AnnotationTracks {
  #onSeek;
  #series = [];         // { name, view: of all but maps, valuesOf(row) }

  // `onSeek(frame)` is called when a line is pressed.
  constructor(onSeek) {
    this.#onSeek = onSeek;
  }

  // Shows the annotations of a replay. `actions`: the catalog's.
  open(replay, frames, actions) {
    const { annotations, rowOfStep } = replay.source;
    this.#series = annotations.map((series) => {
      const { name, valueCount: count } = series;
      const values = valuesByRow(series, rowOfStep);
      const view = annotationView(name, count, actions, this.#onSeek);
      if (count === 1) {
        view.draw([...values].map(([row, [value]]) => [frames.ofRow(row), value]), 0, frames.last);
      }
      return { name, view, valuesOf: (row) => values.get(row) ?? new Array(count).fill(null) };
    });
    const { others } = this.#at(0);
    for (const [id, isLine] of [["annotation-lines", true], ["annotation-bars", false]]) {
      const panels = others.filter(({ view }) => (view.count === 1) === isLine).map(({ view }) => view.panel);
      byId(id).replaceChildren(...panels);
      byId(id).hidden = panels.length === 0;
    }
  }

  // The map at a row, and the other annotations, each with its view.
  #at(row) {
    return splitSaliency(this.#series.map(({ name, view, valuesOf }) => ({ name, view, values: valuesOf(row) })));
  }

  // The values at some rows, as texts: [{ name, texts }].
  textsOf(rows) {
    return this.#at(0).others.map(({ name }, i) => ({ name, texts: rows.map((row) => this.#at(row).others[i].values.map(significant).join(" ")) }));
  }

  // Shows the values of the step that led to a row, at a frame.
  show(row, frame) {
    const { map, others } = this.#at(row);
    drawSaliency(byId("saliency"), map);
    others.forEach(({ view, values }) => view.show(values, frame));
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
