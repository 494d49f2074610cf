// The lines of a plot: which values of which pools are drawn, and their data.

import { baselinesOf } from "../play/baselines.js";
import uPlot from "../vendor/uPlot.js";

export const LINES_MAX = 8;  // lines with a colour of their own

// The lines of `plot`: { name, series, value(row) }. One pool has a line for each member of the plot, or for each of its games;
// several pools have one line each. `settings`: { isNormalised, rangeOf(pool, game) }.
export function linesOf(plot, allSeries, settings) {
  if (allSeries.length > 1) {
    return allSeries.map((series) => ({
      name: series.pool.name, series, value: plot.isReturn ? returnOf(series, settings) : memberOf(plot.members.at(-1)),
    }));
  }
  const [series] = allSeries;
  if (plot.isReturn && series.games.length > 1) {
    return series.games.map((game) => {
      const scale = scaleOf(series.pool, game, settings);
      return { name: game, series, value: (row) => scale(row.gameReturns?.[game]) };
    });
  }
  return plot.members.map((member, index) => ({
    name: plot.names[index], series, value: plot.isReturn ? returnOf(series, settings) : memberOf(member),
  }));
}

// The lower and upper edge of the band around the return of a single line: a standard deviation of the last 100 episodes.
export function bandOf(plot, lines, settings) {
  if (!plot.isReturn || lines.length !== 1) {
    return [];
  }
  const [{ series }] = lines;
  const scale = scaleOf(series.pool, series.pool.games[0], settings);
  const edge = (sign) => ({ meanReturn: mean, returnDeviation: deviation }) => scale((mean ?? null) === null ? null : mean + sign * deviation);
  return [{ name: "", series, value: edge(-1) }, { name: "", series, value: edge(1) }];
}

// The baselines of pools as [name, value], if all play the same game and mode.
export function baselinesOfPools(plot, allSeries, settings) {
  const kinds = new Set(allSeries.flatMap(({ pool: { games, mode } }) => games.map((game) => `${game} ${mode}`)));
  if (!plot.isReturn || kinds.size !== 1) {
    return [];
  }
  const [{ pool: { games: [game], mode }, pool }] = allSeries;
  const scale = scaleOf(pool, game, settings);
  return baselinesOf(game, mode).map(([name, value]) => [name, scale(value)]);
}

function memberOf(member) {
  return (row) => row[member] ?? null;
}

// The mean return of a row; of several games the mean of their normalised returns.
function returnOf(series, settings) {
  if (!settings.isNormalised || series.games.length < 2) {
    const scale = scaleOf(series.pool, series.pool.games[0], settings);
    return ({ meanReturn: value }) => scale(value);
  }
  const scales = series.games.map((game) => [game, scaleOf(series.pool, game, settings)]);
  return ({ gameReturns: returns = {} }) => {
    const values = scales.map(([game, scale]) => scale(returns[game])).filter((value) => value !== null);
    return values.length === 0 ? null : values.reduce((sum, value) => sum + value, 0) / values.length;
  };
}

function scaleOf(pool, game, { isNormalised, rangeOf }) {
  if (!isNormalised) {
    return (value) => value ?? null;
  }
  const { min, max } = rangeOf(pool, game);
  return (value) => ((value ?? null) === null ? null : (value - min) / (max - min));
}

// The columns that uPlot draws: x, then one for each line. `x`: "timeS" or "stepCount"; `smoothing`: see smoothed().
export function dataOf(lines, { x, smoothing }) {
  const allSeries = [...new Set(lines.map(({ series }) => series))];
  const tables = allSeries.map((series) => {
    const rows = increasing(series.rows, x);
    const own = lines.filter((line) => line.series === series);
    return [rows.map((row) => row[x]), ...own.map(({ value }) => smoothed(rows.map((row) => value(row)), smoothing))];
  });
  return tables.length === 1 ? tables[0] : uPlot.join(tables);
}

// An exponential moving average, in which the values before have this weight; 0: the values. Gaps stay.
function smoothed(values, weight) {
  let [sum, total] = [0, 0];
  return weight === 0 ? values : values.map((value) => {
    if (value === null) {
      return null;
    }
    sum = weight * sum + (1 - weight) * value;
    total = weight * total + (1 - weight);
    return sum / total;
  });
}

// Rows with increasing x: the last of those with the same number of steps.
function increasing(rows, x) {
  return x === "timeS" ? rows
    : rows.filter((row, index) => row[x] !== undefined && !(rows[index + 1]?.[x] <= row[x]));
}
