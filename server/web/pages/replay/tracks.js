// What a replay shows along its time line: the score and the learner's annotations. One value is a line, several are bars of the shown
// step, saliency is a map over the agent's view.

import { annotationView, drawSaliency, splitSaliency } from "../elements/annotations.js";
import { byId } from "../elements/elements.js";
import { significant } from "../elements/figures.js";

export class Tracks {
  #onSeek;
  #series = [];  // { name, view, values: of each frame }

  // `onSeek(frame)` is called when a line is pressed.
  constructor(onSeek) {
    this.#onSeek = onSeek;
  }

  // Shows a replay. `actions`: the catalog's.
  open({ source, recording }, frames, actions) {
    const all = Array.from({ length: frames.last + 1 }, (_, i) => frames.at(i));
    const score = all.map(({ row, isStart }) => [isStart ? 0 : recording.viewOf(row).totalReward]);
    this.#series = [this.#seriesOf("score", score, actions), ...source.annotations.map((series) => {
      const values = valuesByRow(series, source.rowOfStep);
      const none = new Array(series.valueCount).fill(null);
      return this.#seriesOf(series.name, all.map(({ row, isStart }) => (isStart ? none : values.get(row) ?? none)), actions);
    })];
    const { others } = this.#at(0);
    for (const [id, isLine] of [["annotation-lines", true], ["annotation-bars", false]]) {
      const panels = others.filter(({ view }) => (view.count === 1) === isLine).map(({ view }) => view.panel);
      byId(id).replaceChildren(...panels);
      byId(id).hidden = panels.length === 0;
    }
  }

  #seriesOf(name, values, actions) {
    const view = annotationView(name, values[0].length, actions, this.#onSeek);
    if (view.count === 1) {
      view.draw(values.map(([value], frame) => [frame, value]), 0, values.length - 1);
    }
    return { name, view, values };
  }

  // The saliency map of a frame, and its other values, each with their view.
  #at(frame) {
    return splitSaliency(this.#series.map(({ name, view, values }) => ({ name, view, values: values[frame] })));
  }

  // The learner's values at all frames, without the map, as texts: [{ name, texts }].
  get texts() {
    return this.#series.slice(1).filter(({ name }) => name !== "saliency")
      .map(({ name, values }) => ({ name, texts: values.map((each) => each.map(significant).join(" ")) }));
  }

  // Shows the values of a frame.
  show(frame) {
    const { map, others } = this.#at(frame);
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
