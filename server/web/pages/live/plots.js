// Plots of the open pool and of those that are compared with it.

import { byId } from "../elements/elements.js";
import { count, milliseconds, rate, reward } from "../elements/figures.js";
import { saveTrace } from "../links/traces.js";
import { attempt } from "../page.js";
import { PoolPlot } from "./plot.js";
import { rowOf } from "./pool_model.js";
import { Series } from "./series.js";

const ROWS_MAX = 4000;  // then the whole history is requested again, which is coarser
const NEWEST_S = 5;     // of history that is requested every second

// The plots: title, the members of a pool that are the lines, their names if there are several, the number format, and whether
// the scale is logarithmic, so that a single stall does not flatten the rest.
const PLOTS = [
  { title: "Mean return", members: ["meanReturn"], names: [""], write: reward, isReturn: true },
  { title: "Steps per second", members: ["stepsPerSecond"], names: [""], write: rate },
  { title: "Request latency", members: ["requestP50Ms", "requestP99Ms"], names: ["p50", "p99"], write: milliseconds, isLog: true },
  { title: "Mean episode length", members: ["meanLength"], names: [""], write: count },
];

export class Plots {
  #connection = null;
  #catalog = null;
  #series = [];    // of the open pool, then of those that are compared with it
  #compared = [];  // names
  #pools = [];     // of the last event
  #zoom = null;    // { min, max } of x
  #plots;

  constructor(place) {
    this.#plots = PLOTS.map((plot) => new PoolPlot(place, plot, (zoom) => this.#setZoom(zoom)));
    byId("span").addEventListener("change", () => {
      this.#setZoom(null);
      this.#series.forEach((series) => this.#load(series));
    });
    byId("x").addEventListener("change", () => this.#setZoom(null));
    byId("smoothing").addEventListener("change", () => this.#draw());
    byId("normalised").addEventListener("change", () => this.#draw());
    byId("unzoom").addEventListener("click", () => this.#setZoom(null));
    byId("csv").addEventListener("click", () => this.#save());
  }

  // Shows a pool; null: none.
  open(connection, catalog, pool) {
    this.#connection = connection;
    this.#catalog = catalog;
    this.#zoom = null;
    this.#series = [];
    this.#addSeries(pool ? [pool] : []);
    this.#draw();
  }

  // Compares pools with the open one. `names`: all of them.
  compare(names) {
    this.#compared = names;
    this.#series = this.#series.filter(({ pool }, index) => index === 0 || names.includes(pool.name));
    this.#addSeries([]);
    this.#draw();
  }

  // Adds the newest values of the series. `pools`: of a report.
  add(pools) {
    this.#pools = pools;
    this.#addSeries([]);
    for (const series of this.#series.filter(({ isBegun }) => isBegun)) {
      if (series.rows.length > ROWS_MAX) {
        this.#load(series);
      } else {
        this.#loadNewest(series);
      }
    }
  }

  // Shows that the current values are not known: gaps in the lines.
  lose() {
    this.#series.forEach((series) => series.lose());
    this.#draw();
  }

  // Adds `pools`, and the compared ones that are missing.
  #addSeries(pools) {
    const isShown = (pool) => this.#series.some((series) => series.pool.name === pool.name);
    const compared = this.#series.length + pools.length > 0 ? this.#pools.filter(({ name }) => this.#compared.includes(name)) : [];
    for (const pool of [...pools, ...compared]) {
      if (!isShown(pool)) {
        const series = new Series(pool);
        this.#series.push(series);
        this.#load(series);
      }
    }
  }

  async #load(series) {
    const spanS = Number(byId("span").value);
    const rows = await this.#requestRows(series, spanS);
    if (rows && this.#series.includes(series) && spanS === Number(byId("span").value)) {
      series.begin(rows, spanS);
      this.#draw();
    }
  }

  async #loadNewest(series) {
    const rows = await this.#requestRows(series, NEWEST_S);
    if (rows && this.#series.includes(series)) {
      series.add(rows);
      this.#draw();
    }
  }

  // Rows of the last seconds of a pool, or null.
  async #requestRows({ pool: { name, gameNames } }, spanS) {
    const history = await attempt(
      () => this.#connection.call("PoolService.GetPoolHistory", { name, span: { seconds: BigInt(spanS) } }), () => {});
    return history?.rows.map((row) => rowOf(row, gameNames));
  }

  #setZoom(zoom) {
    this.#zoom = zoom;
    this.#draw();
  }

  #draw() {
    byId("unzoom").disabled = this.#zoom === null;
    const box = byId("normalised");
    const hasRanges = this.#series.every(({ pool }) => pool.games.every((game) => this.#rangeOf(pool, game)));
    box.disabled = !hasRanges;
    const settings = {
      x: byId("x").value === "time" ? "timeS" : "stepCount", smoothing: Number(byId("smoothing").value),
      span: byId("span").selectedOptions[0].text, zoom: this.#zoom,
      isNormalised: hasRanges && box.checked, rangeOf: (pool, game) => this.#rangeOf(pool, game),
    };
    this.#plots.forEach((plot) => plot.draw(this.#series, settings));
  }

  // The catalog's range of returns: { min, max }; undefined if it has none for the game and mode.
  #rangeOf(pool, game) {
    const { modes } = this.#catalog.games.find(({ name }) => name === game);
    return modes.find(({ name }) => name === pool.mode)?.returnRange;
  }

  // Downloads the rows of all shown pools; those with the same columns share a header.
  #save() {
    const lines = [];
    let header = "";
    for (const series of this.#series) {
      if (series.csvHeader !== header) {
        header = series.csvHeader;
        lines.push(header);
      }
      lines.push(...series.toCsv());
    }
    const name = this.#series.map(({ pool }) => pool.name.replace("pools/", "")).join("-").slice(0, 100);
    saveTrace(new TextEncoder().encode(`${lines.join("\n")}\n`), `${name}.csv`);
  }
}
