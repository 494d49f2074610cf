// One plot of pools: lines over time or steps, with the values under the cursor, and zoom.

import { baseOptions, Chart } from "../elements/chart.js";
import { colorsOf } from "../elements/colors.js";
import { element, setText } from "../elements/elements.js";
import { clock, NONE, rate, reward } from "../elements/figures.js";
import { bandOf, baselinesOfPools, dataOf, LINES_MAX, linesOf } from "./lines.js";

const HEIGHT_PX = 152;
const RETURN_HEIGHT_PX = 240;
const TICKS_S = [1, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 10800, 21600, 43200];
const COLORS = Array.from({ length: LINES_MAX }, (_, index) => `line-${index}`);
const KEY_STEP = 0.02;  // of the width, for a press of an arrow key

export class PoolPlot {
  #plot;
  #onZoom;
  #where = element("span", { class: "quiet" });
  #legend = element("span", { class: "number" });
  #place;
  #chart;
  #key = "";        // of the lines and settings that the chart was made for
  #lines = [];
  #band = [];
  #baselines = [];  // [name, value]
  #data = [[]];
  #settings = null;

  // `onZoom(zoom)` is called when the user selects a part of x, { min, max }, or null for all of it.
  constructor(place, plot, onZoom) {
    this.#plot = plot;
    this.#onZoom = onZoom;
    this.#place = element("div", { class: "drawing", role: "img", tabindex: "0", "aria-label": plot.title, onkeydown: (event) => this.#press(event) });
    place.append(element("figure", { class: `plot panel${plot.isReturn ? " return" : ""}` }, element("h3", {}, plot.title, this.#where, this.#legend), this.#place));
    this.#chart = new Chart(this.#place, plot.isReturn ? RETURN_HEIGHT_PX : HEIGHT_PX, () => this.#options());
  }

  // Draws the series of pools; without any, nothing.
  draw(allSeries, settings) {
    this.#settings = settings;
    this.#lines = allSeries.length === 0 ? [] : linesOf(this.#plot, allSeries, settings).slice(0, 2 * LINES_MAX);
    this.#band = bandOf(this.#plot, this.#lines, settings);
    this.#baselines = baselinesOfPools(this.#plot, allSeries, settings);
    this.#data = this.#lines.length === 0 ? [[]] : dataOf([...this.#lines, ...this.#band], settings);
    this.#data = [...this.#data, ...this.#baselines.map(([, value]) => this.#data[0].map(() => value))];
    const key = JSON.stringify([this.#lines.map(({ name }) => name), this.#band.length, this.#baselines, settings.x]);
    const isOther = key !== this.#key;
    this.#key = key;
    if (isOther) {
      const format = this.#format();
      this.#legend.replaceChildren(...this.#lines.map((_, line) => coloured(colorOf(line))),
        ...this.#baselines.map(([name, value]) => element("span", { class: "baseline" }, `${name} ${format(value)}`)));
    }
    this.#chart.draw(this.#data, isOther);
    this.#write(this.#chart.plot?.cursor.idx);
    const over = settings.x === "timeS" ? `the ${settings.span.toLowerCase()}` : "steps";
    this.#place.setAttribute("aria-label", `${this.#plot.title} over ${over}, now ${this.#texts(null).join(", ")}`);
  }

  // Writes the values at an index of the data; null: the newest of each line.
  #write(index) {
    const x = index == null ? null : this.#data[0][index];
    setText(this.#where, x == null ? "" : this.#settings.x === "timeS" ? clock(x) : `${rate(x)} steps`);
    this.#texts(index ?? null).forEach((text, line) => setText(this.#legend.children[line], text));
  }

  // The format of values.
  #format() {
    const { isReturn, write } = this.#plot;
    return isReturn && this.#settings.isNormalised ? (value) => (value === null ? NONE : value.toFixed(2)) : write;
  }

  #texts(index) {
    const format = this.#format();
    const newest = ({ series: { rows }, value }) => (rows.length === 0 ? null : value(rows.at(-1)));
    const valueOf = (line, column) => format((index === null ? newest(line) : this.#data[column][index]) ?? null);
    const [low, high] = this.#band.map((line, edge) => valueOf(line, this.#lines.length + 1 + edge));
    const band = low === undefined ? "" : ` (${low} to ${high})`;
    return this.#lines.map((line, i) => `${line.name} ${valueOf(line, i + 1)}${band}`.trim());
  }

  #options() {
    const colors = colorsOf(...COLORS, "quiet");
    const isTime = this.#settings.x === "timeS";
    const base = baseOptions(isTime ? minute : rate, this.#plot.isReturn ? reward : this.#plot.write);
    const [xAxis, yAxis] = base.axes;
    const stroke = (index) => colors[colorOf(index)];
    const band = this.#band.length === 0 ? {} : {
      bands: [{ series: [this.#lines.length + 2, this.#lines.length + 1], fill: stroke(0).replace("rgb(", "rgba(").replace(")", ", 0.2)") }],
    };
    return {
      ...base,
      ...band,
      cursor: {
        y: false,
        drag: { x: true, y: false, setScale: false },
        sync: { key: "pools", filters: { pub: (type) => type === "mousemove" || type === "mouseleave" } },
        bind: { dblclick: () => () => this.#onZoom(null) },
      },
      hooks: { setCursor: [(chart) => this.#write(chart.cursor.idx)], setSelect: [(chart) => this.#select(chart)] },
      scales: {
        x: { time: isTime, range: (chart, min, max) => this.#rangeOfX(min, max) },
        y: this.#plot.isLog ? { distr: 3 } : { range: (chart, min, max) => rangeOf(min, max) },
      },
      axes: [
        isTime ? { ...xAxis, incrs: TICKS_S } : xAxis,
        this.#plot.isLog ? { ...yAxis, grid: { ...yAxis.grid, filter: decades } } : yAxis,
      ],
      series: [
        {},
        ...this.#lines.map((_, index) => ({ stroke: stroke(index), dash: index < LINES_MAX ? [] : [4, 4], width: 1.75, points: { show: false } })),
        ...this.#band.map(() => ({ stroke: "transparent", points: { show: false } })),
        ...this.#baselines.map((_, index) => ({ stroke: colors.quiet, dash: index === 0 ? [2, 4] : [8, 4], width: 1, points: { show: false } })),
      ],
    };
  }

  #rangeOfX(min, max) {
    const { zoom } = this.#settings;
    if (zoom) {
      return [zoom.min, zoom.max];
    }
    if (min === null) {
      return [0, 1];
    }
    return min === max ? [min - 1, max + 1] : [min, max];
  }

  #select(chart) {
    const { left, width } = chart.select;
    if (width > 0) {
      chart.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
      this.#onZoom({ min: chart.posToVal(left, "x"), max: chart.posToVal(left + width, "x") });
    }
  }

  // By keyboard: arrows move the cursor, + and - zoom around it, Escape shows all.
  #press(event) {
    const chart = this.#chart.plot;
    const width = this.#chart.plot?.over.clientWidth ?? 0;
    const left = chart?.cursor.left >= 0 ? chart.cursor.left : width / 2;
    const acts = {
      ArrowLeft: () => chart.setCursor({ left: Math.max(0, left - width * KEY_STEP), top: 1 }),
      ArrowRight: () => chart.setCursor({ left: Math.min(width, left + width * KEY_STEP), top: 1 }),
      "+": () => this.#zoomAround(chart.posToVal(left, "x"), 0.5),
      "-": () => this.#zoomAround(chart.posToVal(left, "x"), 2),
      Escape: () => this.#onZoom(null),
    };
    if (chart && acts[event.key]) {
      event.preventDefault();
      acts[event.key]();
    }
  }

  #zoomAround(x, factor) {
    const { min, max } = this.#chart.plot.scales.x;
    this.#onZoom({ min: x - (x - min) * factor, max: x + (max - x) * factor });
  }
}

function colorOf(index) {
  return COLORS[index % LINES_MAX];
}

function coloured(color) {
  const span = element("span");
  span.style.color = `var(--${color})`;
  return span;
}

// Grid lines of a logarithmic scale: 1, 10, 100.
function decades(chart, ticks) {
  return ticks.map((tick) => (Number.isInteger(Math.log10(tick)) ? tick : null));
}

// Starts at zero if all values are positive, with some margin. Without values the labels are whole numbers.
function rangeOf(min, max) {
  if (min === null || max === null) {
    return [0, 10];
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
