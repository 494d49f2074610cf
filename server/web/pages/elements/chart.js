// A chart drawn by uPlot (vendor/), which follows the width of its place and the theme.

import uPlot from "../vendor/uPlot.js";
import { colorsOf } from "./colors.js";

export class Chart {
  #place;
  #heightPx;
  #describe;
  #data = null;
  #chart = null;

  // `describe()` returns uPlot's options, with the current colours.
  constructor(place, heightPx, describe) {
    this.#place = place;
    this.#heightPx = heightPx;
    this.#describe = describe;
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.#data && this.draw(this.#data, true));
    new ResizeObserver(() => this.#fit()).observe(place);
  }

  // Draws columns of equal length: x, then one for each series. A hidden chart is drawn when it is shown. `isOther`: the series
  // are others than before.
  draw(data, isOther = false) {
    this.#data = data;
    if (isOther) {
      this.#forget();
    }
    if (this.#place.clientWidth === 0) {
      return;
    }
    if (this.#chart) {
      this.#chart.setData(data);
    } else {
      const size = { width: this.#place.clientWidth, height: this.#heightPx };
      this.#chart = new uPlot({ ...size, ...this.#describe() }, data, this.#place);
    }
  }


  // uPlot's chart; null if nothing is drawn.
  get plot() {
    return this.#chart;
  }

  #forget() {
    this.#chart?.destroy();
    this.#chart = null;
  }

  #fit() {
    if (this.#chart && this.#place.clientWidth > 0) {
      this.#chart.setSize({ width: this.#place.clientWidth, height: this.#heightPx });
    } else if (this.#data) {
      this.draw(this.#data);
    }
  }
}

// Options that all charts share. `writeX` and `writeY` format the labels of the axes.
export function baseOptions(writeX, writeY) {
  const { quiet, line } = colorsOf("quiet", "line");
  const axis = { stroke: quiet, font: "12px system-ui, sans-serif", grid: { stroke: line, width: 1 }, ticks: { show: false } };
  const label = (write) => (chart, ticks) => ticks.map((tick) => (tick === null ? "" : write(tick)));
  return {
    legend: { show: false },
    padding: [10, 32, 0, 0],  // half of the last label
    axes: [
      { ...axis, grid: { show: false }, size: 26, space: 70, values: label(writeX) },
      { ...axis, size: 56, space: 34, values: label(writeY) },
    ],
  };
}
