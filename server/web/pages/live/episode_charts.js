// Charts of a pool's last episodes: a histogram of returns, and the mean return of each level.

import { baseOptions, Chart } from "../elements/chart.js";
import { colorsOf } from "../elements/colors.js";
import { element, setText } from "../elements/elements.js";
import { count, plural, rate, reward } from "../elements/figures.js";
import uPlot from "../vendor/uPlot.js";

const HEIGHT_PX = 168;
const BINS_MAX = 20;
const LEVELS_MAX = 200;  // shown one by one

// A figure with a title, the values under the cursor, and a chart.
class EpisodeChart {
  #place = element("div", { class: "drawing", role: "img" });
  #values = element("span", { class: "number" });
  #title;
  chart;

  // `describe()`: options of the chart beside those of all; `write(index)`: the values at an index.
  constructor(place, title, describe, write) {
    this.#title = title;
    place.append(element("figure", { class: "plot" }, element("h4", {}, title, this.#values), this.#place));
    const setCursor = (plot) => setText(this.#values, plot.cursor.idx == null ? "" : write(plot.cursor.idx));
    const cursor = { y: false, drag: { x: false, y: false } };
    this.chart = new Chart(this.#place, HEIGHT_PX, () => ({ ...describe(), cursor, hooks: { setCursor: [setCursor] } }));
  }

  name(summary) {
    this.#place.setAttribute("aria-label", `${this.#title}: ${summary}`);
  }
}

export class ReturnHistogram extends EpisodeChart {
  #bins = { centers: [], counts: [], width: 1 };

  constructor(place) {
    super(place, "Returns", () => {
      const { accent } = colorsOf("accent");
      const edge = () => this.#bins.width / 2;
      return {
        ...baseOptions(reward, count),
        scales: {
          x: { time: false, range: (chart, min, max) => [min - edge(), max + edge()] },
          y: { range: (chart, min, max) => [0, max * 1.1] },
        },
        series: [{}, { stroke: accent, fill: accent, paths: uPlot.paths.bars({ size: [0.9, 64] }), points: { show: false } }],
      };
    }, (index) => this.#write(index));
  }

  draw(episodes) {
    const returns = episodes.map(({ totalReward: value }) => value).sort((one, other) => one - other);
    this.#bins = binsOf(returns);
    this.name(`${plural(returns.length, "episode")}, from ${reward(returns[0])} to ${reward(returns.at(-1))},`
      + ` median ${reward(returns[Math.floor(returns.length / 2)])}`);
    this.chart.draw([this.#bins.centers, this.#bins.counts]);
  }

  #write(index) {
    const { centers, counts, width } = this.#bins;
    const [from, to] = [centers[index] - width / 2, centers[index] + width / 2];
    return `${reward(from)} to ${reward(to)}: ${plural(counts[index], "episode")}`;
  }
}

// Divides sorted values into bins of the same width: { centers, counts, width }.
function binsOf(values) {
  const low = values[0];
  const span = values.at(-1) - low;
  const binCount = span === 0 ? 1 : BINS_MAX;
  const width = span === 0 ? 1 : span / (binCount - 1);
  const counts = new Array(binCount).fill(0);
  values.forEach((value) => { counts[Math.round((value - low) / width)] += 1; });
  return { counts, width, centers: counts.map((_, bin) => low + bin * width) };
}

// Dots for levels; bars for ranges of seeds if there are more levels than a reader can tell apart.
export class LevelReturns extends EpisodeChart {
  #levels = [];
  #areRanges = false;

  constructor(place) {
    super(place, "Mean return by level seed", () => {
      const { accent, warn } = colorsOf("accent", "warn");
      const dots = (color, size) => ({ stroke: color, paths: () => null, points: { show: true, size, stroke: color, fill: color } });
      const bars = { stroke: accent, fill: accent, paths: uPlot.paths.bars({ size: [0.9, 64] }), points: { show: false } };
      const margin = () => (this.#areRanges ? (this.#levels[1].seed - this.#levels[0].seed) / 2 : 1);
      return {
        ...baseOptions(rate, reward),
        scales: { x: { time: false, range: (chart, min, max) => [min - margin(), max + margin()] } },
        series: this.#areRanges ? [{}, bars] : [{}, dots(accent, 5), dots(warn, 7)],
      };
    }, (index) => this.#write(index));
  }

  draw(episodes) {
    const levels = levelsOf(episodes);
    const failed = levels.filter(({ completed }) => completed === 0);
    this.name(`${plural(levels.length, "level")}, of which ${count(failed.length)} were never completed`);
    const wereRanges = this.#areRanges;
    this.#areRanges = levels.length > LEVELS_MAX;
    this.#levels = this.#areRanges ? rangesOf(levels) : levels;
    const seeds = this.#levels.map(({ seed }) => seed);
    const means = (isShown) => this.#levels.map((level) => (isShown(level) ? level.mean : null));
    this.chart.draw(this.#areRanges ? [seeds, means(() => true)]
      : [seeds, means(({ completed }) => completed > 0), means(({ completed }) => completed === 0)], wereRanges !== this.#areRanges);
  }

  #write(index) {
    const { seed, width, episodes, mean, completed } = this.#levels[index];
    const where = this.#areRanges ? `levels ${rate(seed - width / 2)} to ${rate(seed + width / 2)}` : `level ${seed}`;
    return `${where}: ${reward(mean)}, ${completed} of ${episodes} completed`;
  }
}

// Levels by ranges of seeds, whose middle is `seed`: { seed, width, episodes, completed, mean }.
function rangesOf(levels) {
  const low = levels[0].seed;
  const width = (levels.at(-1).seed - low + 1) / BINS_MAX;
  return Array.from({ length: BINS_MAX }, (_, i) => {
    const inside = levels.filter(({ seed }) => Math.floor((seed - low) / width) === i);
    const sum = (valueOf) => inside.reduce((total, level) => total + valueOf(level), 0);
    const episodes = sum((level) => level.episodes);
    return {
      seed: low + (i + 0.5) * width, width, episodes, completed: sum(({ completed }) => completed),
      mean: episodes === 0 ? null : sum((level) => level.mean * level.episodes) / episodes,
    };
  });
}

// The levels of episodes by seed: { seed, episodes, completed, mean }.
export function levelsOf(episodes) {
  const levels = new Map();
  for (const { levelSeed: seed, totalReward: value, levelComplete: isComplete } of episodes) {
    const level = levels.get(seed) ?? { seed, episodes: 0, completed: 0, sum: 0 };
    level.episodes += 1;
    level.completed += isComplete ? 1 : 0;
    level.sum += value;
    levels.set(seed, level);
  }
  return [...levels.values()].map((level) => ({ ...level, mean: level.sum / level.episodes }))
    .sort((one, other) => one.seed - other.seed);
}
