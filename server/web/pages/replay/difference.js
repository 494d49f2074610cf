// The first difference of two replays.

import { NONE, reward } from "../elements/figures.js";

// The level seeds of all rows.
function levelSeeds({ rows, level_seeds: changes }) {
  const seeds = new Array(rows);
  changes.forEach(([row, seed], i) => seeds.fill(seed, row, changes[i + 1]?.[0] ?? rows));
  return seeds;
}

// What differs before the first row: [name, value, other value], or undefined.
function levelDifference({ header: one }, { header: other }) {
  const game = ({ games, environment }) => games[environment % games.length];
  const names = Object.keys(one.options).filter((name) => !["num_levels", "start_level", "rand_seed"].includes(name));
  const all = [["game", game(one), game(other)], ["mode", one.mode, other.mode],
    ...names.map((name) => [name.replaceAll("_", " "), one.options[name], other.options[name]])];
  return all.find(([, value, expected]) => value !== expected);
}

// Returns { row, name, values: [of one, of other] } as texts, or null. `one`, `other`: answers of replay.open; `actionNames`: names by
// number. A row differs by the action that led to it, its reward, its level, or the end of an episode.
export function firstDifference(one, other, actionNames) {
  const level = levelDifference(one, other);
  if (level) {
    return { row: 0, name: level[0], values: level.slice(1).map(String) };
  }
  const sides = [one, other].map((replay) => ({ replay, seeds: levelSeeds(replay), first: new Set(replay.first) }));
  const rows = Math.min(one.rows, other.rows);
  for (let row = 0; row < rows; row += 1) {
    const fields = [
      ["action", ({ replay }) => (row === 0 ? NONE : actionNames.get(replay.actions[row - 1]) ?? replay.actions[row - 1])],
      ["reward", ({ replay }) => reward(replay.rewards[row])],
      ["episode", ({ first }) => (row > 0 && first.has(row) ? "ended" : "running")],
      ["level seed", ({ seeds }) => seeds[row]],
    ];
    for (const [name, valueOf] of fields) {
      const values = sides.map((side) => String(valueOf(side)));
      if (values[0] !== values[1]) {
        return { row, name, values };
      }
    }
  }
  return one.rows === other.rows ? null
    : { row: rows - 1, name: "number of steps", values: [one, other].map(({ rows: all }) => String(all - 1)) };
}
