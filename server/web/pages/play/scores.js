// The best scores of this browser, by game and mode, beside the mean returns of a random agent and of the reference learner.

import { byId, setText } from "../elements/elements.js";
import { reward } from "../elements/figures.js";
import { LEARNER_BASELINE } from "./learner_baseline.js";
import { RANDOM_BASELINE } from "./random_baseline.js";

const KEY = "best scores";

function bestScores() {
  return JSON.parse(localStorage.getItem(KEY)) ?? {};
}

function keyOf({ game, mode }) {
  return `${game}.${mode}`;
}

// Records the score of a level, { game, mode, options }. Returns whether it is the best so far and more than nothing. Levels with
// options that differ from their defaults do not count, because some make a game easier.
export function recordScore(level, score) {
  const best = bestScores();
  const before = best[keyOf(level)] ?? 0;
  if (Object.keys(level.options).length > 0 || score <= before) {
    return false;
  }
  localStorage.setItem(KEY, JSON.stringify({ ...best, [keyOf(level)]: score }));
  showScores(level);
  return true;
}

export function showScores(level) {
  const { game, mode } = level;
  const best = bestScores()[keyOf(level)];
  const random = RANDOM_BASELINE[game]?.[mode];
  const learner = LEARNER_BASELINE[game]?.[mode];
  setText(byId("scores"), [
    best === undefined ? "" : `Your best score in ${game}, ${mode}: ${reward(best)}.`,
    random === undefined ? "" : `A random agent's mean: ${reward(random)}.`,
    learner === undefined ? "" : `PPO's after 25 million steps: ${reward(learner)}.`,
  ].join(" ").trim());
}
