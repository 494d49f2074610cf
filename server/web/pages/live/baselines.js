// Mean returns to compare a pool with: of a random agent, and of the reference learner.

import { LEARNER_BASELINE } from "../play/learner_baseline.js";
import { RANDOM_BASELINE } from "../play/random_baseline.js";

const BASELINES = [["random agent", RANDOM_BASELINE], ["PPO, 25 million steps", LEARNER_BASELINE]];

// The baselines of pools, if all play the same game and mode: { name, value }. `settings`: as those of lines.js.
export function baselinesOf(plot, allSeries, { isNormalised, rangeOf }) {
  const [first] = allSeries;
  const isSame = ({ pool: { games, mode } }) => games.every((game) => game === first.pool.games[0]) && mode === first.pool.mode;
  if (!plot.isReturn || allSeries.length === 0 || !allSeries.every(isSame)) {
    return [];
  }
  const { games: [game], mode } = first.pool;
  const { min = 0, max = 1 } = isNormalised ? rangeOf(first.pool, game) : {};
  return BASELINES.map(([name, values]) => ({ name, value: values[game]?.[mode] }))
    .filter(({ value }) => value !== undefined)
    .map(({ name, value }) => ({ name, value: isNormalised ? (value - min) / (max - min) : value }));
}
