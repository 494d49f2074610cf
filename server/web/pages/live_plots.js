// Plots of a pool over the last ten minutes, drawn by uPlot (vendor/).

import { colorsOf } from "./colors.js";
import { element, setText } from "./elements.js";
import { clock, count, milliseconds, rate, reward } from "./figures.js";

const SPAN_S = 600;
const HEIGHT_PX = 152;

// The plots: title, the members of a pool that are the lines, their labels if there are several, the number format, and
// whether the scale is logarithmic, so that a single stall does not flatten the rest.
const PLOTS = [
  { title: "Steps per second", lines: ["steps_per_second"], names: [""], write: rate },
  { title: "Request latency", lines: ["request_p50_ms", "request_p99_ms"], names: ["p50 ", "p99 "], write: milliseconds, isLog: true },
  { title: "Mean return", lines: ["mean_return"], names: [""], write: reward },
  { title: "Mean episode length", lines: ["mean_length"], names: [""], write: count },
];
const MEMBERS = PLOTS.flatMap(({ lines }) => lines);

export class Plots {
  #drawings;
  #times = [];
  #values = Object.fromEntries(MEMBERS.map((name) => [name, []]));
  #isBegun = false;

  constructor(place) {
    this.#drawings = PLOTS.map((plot) => new Drawing(place, plot));
    document.addEventListener("theme", () => this.#redraw());
    // Figures follow the width of the page.
    new ResizeObserver(() => this.#drawings.forEach((drawing) => drawing.fit())).observe(place);
  }

  clear() {
    this.#isBegun = false;
    this.#times.length = 0;
    MEMBERS.forEach((name) => { this.#values[name].length = 0; });
    this.#draw();
  }

  // Starts with the server's history: the answer of pool.history.
  begin({ columns, rows }) {
    this.clear();
    for (const row of rows) {
      const pool = Object.fromEntries(columns.map((name, index) => [name, row[index]]));
      this.#append(pool, pool.time_s);
    }
    this.#isBegun = true;
    this.#draw();
  }

  // Adds the pool's values of the event at `time`.
  add(pool, time) {
    if (this.#isBegun && time > (this.#times.at(-1) ?? 0)) {
      this.#append(pool, time);
      this.#draw();
    }
  }

  #append(pool, time) {
    this.#times.push(time);
    MEMBERS.forEach((name) => this.#values[name].push(pool[name] ?? null));
    while (this.#times[0] < time - SPAN_S) {
      this.#times.shift();
      MEMBERS.forEach((name) => this.#values[name].shift());
    }
  }

  #draw() {
    this.#drawings.forEach((drawing) => drawing.draw(this.#times, this.#values));
  }

  #redraw() {
    this.#drawings.forEach((drawing) => drawing.forget());
    this.#draw();
  }
}

// One plot with its title and its newest value.
class Drawing {
  #plot;
  #newest;
  #place;
  #chart = null;

  constructor(place, plot) {
    this.#plot = plot;
    this.#newest = plot.lines.map((_, index) => element("span", { class: `line-${index}` }));
    this.#place = element("div", { class: "drawing", role: "img", "aria-label": plot.title });
    place.append(element("figure", { class: "plot panel" },
      element("h3", {}, plot.title, element("span", { class: "number" }, ...this.#newest)), this.#place));
  }

  draw(times, values) {
    const { lines, names, title, write } = this.#plot;
    const newest = lines.map((name, index) => names[index] + write(values[name].at(-1)));
    newest.forEach((text, index) => setText(this.#newest[index], text));
    this.#place.setAttribute("aria-label", `${title} over the last ten minutes, now ${newest.join(", ")}`);
    const drawn = [times, ...lines.map((name) => values[name])];
    if (this.#place.clientWidth === 0) {
      return;
    }
    this.#chart ??= new window.uPlot(this.#options(), drawn, this.#place);
    this.#chart.setData(drawn);
  }

  fit() {
    this.#chart?.setSize({ width: this.#place.clientWidth, height: HEIGHT_PX });
  }

  // The next drawing starts from scratch, with the current colours.
  forget() {
    this.#chart?.destroy();
    this.#chart = null;
  }

  #options() {
    const { ink, quiet, line, accent, warn } = colorsOf("ink", "quiet", "line", "accent", "warn");
    const strokes = [accent, warn];
    const { write, lines, isLog } = this.#plot;
    const axis = { stroke: quiet, font: "12px system-ui, sans-serif", grid: { stroke: line, width: 1 }, ticks: { show: false } };
    return {
      width: this.#place.clientWidth,
      height: HEIGHT_PX,
      legend: { show: false },
      cursor: { show: false },
      padding: [10, 18, 0, 0],
      scales: { y: isLog ? { distr: 3 } : { range: (chart, min, max) => rangeOf(min, max) } },
      axes: [
        { ...axis, grid: { show: false }, size: 26, space: 70, values: (chart, ticks) => ticks.map(minute) },
        { ...axis, grid: isLog ? { ...axis.grid, filter: decades } : axis.grid, size: 56, space: 34, values: (chart, ticks) => ticks.map((tick) => (tick === null ? "" : write(tick))) },
      ],
      series: [{}, ...lines.map((name, index) => ({ stroke: strokes[index] ?? ink, width: 1.75, points: { show: false } }))],
    };
  }
}

// Grid lines of a logarithmic scale: 1, 10, 100.
function decades(chart, ticks) {
  return ticks.map((tick) => (Number.isInteger(Math.log10(tick)) ? tick : null));
}

// Starts at zero if all values are positive, with some margin.
function rangeOf(min, max) {
  if (min === null || max === null) {
    return [0, 1];
  }
  const low = Math.min(0, min);
  const high = Math.max(0, max);
  return [low * 1.1, high === low ? low + 1 : high * 1.1];
}

// 08:10, with seconds for ticks between minutes.
function minute(seconds) {
  const time = clock(seconds);
  return time.endsWith(":00") ? time.slice(0, -3) : time;
}
