// Charts of a pool's last episodes: a histogram of returns, and the mean return by level seed.

import { baseOptions, Chart } from "../elements/chart.js";
import { colorsOf } from "../elements/colors.js";
import { element, setText } from "../elements/elements.js";
import { count, plural, rate, reward } from "../elements/figures.js";
import uPlot from "../vendor/uPlot.js";

const HEIGHT_PX = 168;
const BINS_MAX = 20;
const LEVELS_MAX = 200;  // span of seeds with a bar for each

// Bars, with the text of the one under the cursor beside the title.
export class BarChart {
  #place = element("div", { class: "drawing", role: "img" });
  #title;
  #chart;
  #bins = [];
  #width = 1;

  // `writeX`, `writeY`: formats of the axes.
  constructor(place, title, writeX, writeY) {
    this.#title = title;
    const text = element("span", { class: "number" });
    place.append(element("figure", { class: "plot" }, element("h4", {}, title, text), this.#place));
    const setCursor = ({ cursor }) => setText(text, cursor.idx == null ? "" : this.#bins[cursor.idx].text);
    this.#chart = new Chart(this.#place, HEIGHT_PX, () => {
      const { accent } = colorsOf("accent");
      return {
        ...baseOptions(writeX, writeY),
        scales: {
          x: { time: false, range: (chart, min, max) => [min - this.#width / 2, max + this.#width / 2] },
          y: { range: (chart, min, max) => [Math.min(0, min), max * 1.1] },
        },
        series: [{}, { stroke: accent, fill: accent, paths: uPlot.paths.bars({ size: [0.9, 64] }), points: { show: false } }],
        cursor: { y: false, drag: { x: false, y: false } }, hooks: { setCursor: [setCursor] },
      };
    });
  }

  // Draws bins of the same width, { center, value: null for none, text }. `summary` describes them.
  draw({ bins, width, summary }) {
    this.#bins = bins;
    this.#width = width;
    this.#place.setAttribute("aria-label", `${this.#title}: ${summary}`);
    this.#chart.draw([bins.map(({ center }) => center), bins.map(({ value }) => value)]);
  }
}

// Divides [low, high] into bins of the same width, around whose centers the first and the last value are: the bins, each with its items.
function divide(items, valueOf, low, width, binCount) {
  const bins = Array.from({ length: binCount }, (_, bin) => ({ center: low + bin * width, items: [] }));
  items.forEach((item) => bins[Math.round((valueOf(item) - low) / width)].items.push(item));
  return bins;
}

// The histogram of returns.
export function returnBins(episodes) {
  const returns = episodes.map(({ totalReward: value }) => value).sort((one, other) => one - other);
  const [low, high] = [returns[0], returns.at(-1)];
  const binCount = low === high ? 1 : BINS_MAX;
  const width = low === high ? 1 : (high - low) / (binCount - 1);
  return {
    width, summary: `${plural(returns.length, "episode")}, from ${reward(low)} to ${reward(high)}, median ${reward(returns[Math.floor(returns.length / 2)])}`,
    bins: divide(returns, (value) => value, low, width, binCount).map(({ center, items }) => ({
      center, value: items.length,
      text: `${reward(center - width / 2)} to ${reward(center + width / 2)}: ${plural(items.length, "episode")}`,
    })),
  };
}

// The mean returns of levels, or of ranges of seeds if these span more levels than a reader can tell apart.
export function levelBins(episodes) {
  const seedOf = ({ levelSeed }) => levelSeed;
  const seeds = [...new Set(episodes.map(seedOf))].sort((one, other) => one - other);
  const completed = new Set(episodes.filter(({ levelComplete }) => levelComplete).map(seedOf));
  const span = seeds.at(-1) - seeds[0] + 1;
  const binCount = span > LEVELS_MAX ? BINS_MAX : span;
  const width = span > LEVELS_MAX ? (span - 1) / (binCount - 1) : 1;
  return {
    width, summary: `${plural(seeds.length, "level")}, of which ${count(seeds.length - completed.size)} were never completed`,
    bins: divide(episodes, seedOf, seeds[0], width, binCount).map(({ center, items }) => {
      const mean = items.length === 0 ? null : items.reduce((sum, { totalReward: value }) => sum + value, 0) / items.length;
      const where = width === 1 ? `level ${center}` : `levels ${rate(center - width / 2)} to ${rate(center + width / 2)}`;
      return { center, value: mean, text: `${where}: ${reward(mean)}, ${items.filter(({ levelComplete }) => levelComplete).length} of ${items.length} completed` };
    }),
  };
}
