// Charts of a pool's last episodes: a histogram of returns, and the mean return of each level.

import { baseOptions, Chart } from "../elements/chart.js";
import { colorsOf } from "../elements/colors.js";
import { element, setText } from "../elements/elements.js";
import { count, plural, rate, reward } from "../elements/figures.js";

const HEIGHT_PX = 168;
const BINS_MAX = 20;

// A figure with a title, the values under the cursor, and a chart.
class EpisodeChart {
  #place = element("div", { class: "drawing", role: "img" });
  #values = element("span", { class: "number" });
  #title;
  chart;

  constructor(place, title, describe) {
    this.#title = title;
    place.append(element("figure", { class: "plot" }, element("h4", {}, title, this.#values), this.#place));
    const setCursor = (plot) => setText(this.#values, plot.cursor.idx == null ? "" : this.write(plot.cursor.idx));
    const cursor = { y: false, drag: { x: false, y: false } };
    this.chart = new Chart(this.#place, HEIGHT_PX, () => ({ ...describe(), cursor, hooks: { setCursor: [setCursor] } }));
  }

  name(summary) {
    this.#place.setAttribute("aria-label", `${this.#title}: ${summary}`);
  }
}

export class ReturnHistogram extends EpisodeChart {
  #bins = [];

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
        series: [{}, { stroke: accent, fill: accent, paths: window.uPlot.paths.bars({ size: [0.9, 64] }), points: { show: false } }],
      };
    });
  }

  draw(episodes) {
    const returns = episodes.map(({ totalReward: value }) => value).sort((one, other) => one - other);
    this.#bins = binsOf(returns);
    this.name(`${plural(returns.length, "episode")}, from ${reward(returns[0])} to ${reward(returns.at(-1))},`
      + ` median ${reward(returns[Math.floor(returns.length / 2)])}`);
    this.chart.draw([this.#bins.centers, this.#bins.counts]);
  }

  write(index) {
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

export class LevelReturns extends EpisodeChart {
  #levels = [];

  constructor(place) {
    super(place, "Mean return by level seed", () => {
      const { accent, warn } = colorsOf("accent", "warn");
      const dots = (color, size) => ({ stroke: color, paths: () => null, points: { show: true, size, stroke: color, fill: color } });
      return {
        ...baseOptions(rate, reward),
        scales: { x: { time: false, range: (chart, min, max) => [min - 1, max + 1] } },
        series: [{}, dots(accent, 5), dots(warn, 7)],
      };
    });
  }

  draw(episodes) {
    this.#levels = levelsOf(episodes);
    const failed = this.#levels.filter(({ completed }) => completed === 0);
    this.name(`${plural(this.#levels.length, "level")}, of which ${count(failed.length)} were never completed`);
    this.chart.draw([
      this.#levels.map(({ seed }) => seed),
      this.#levels.map(({ completed, mean }) => (completed > 0 ? mean : null)),
      this.#levels.map(({ completed, mean }) => (completed > 0 ? null : mean)),
    ]);
  }

  write(index) {
    const { seed, episodes, mean, completed } = this.#levels[index];
    return `level ${seed}: ${reward(mean)}, ${completed} of ${episodes} completed`;
  }
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
