// The first difference of two replays.

import { NONE, reward } from "../elements/figures.js";

// What differs before the first row: [name, value, other value], or undefined.
function levelDifference({ source: one }, { source: other }) {
  const game = ({ games, environment }) => games[environment % games.length];
  const names = Object.keys(one.options).filter((name) => !["num_levels", "start_level", "rand_seed"].includes(name));
  const all = [["game", game(one), game(other)], ["mode", one.mode, other.mode],
    ...names.map((name) => [name.replaceAll("_", " "), one.options[name], other.options[name]])];
  return all.find(([, value, expected]) => value !== expected);
}

// Returns { row, name, values: [of one, of other] } as texts, or null. `one`, `other`: of ReplayRun; `actionNames`: names by
// number. A row differs by the action that led to it, its reward, its level, or the end of an episode.
export function firstDifference(one, other, actionNames) {
  const level = levelDifference(one, other);
  if (level) {
    return { row: 0, name: level[0], values: level.slice(1).map(String) };
  }
  const sides = [one.recording, other.recording];
  const rows = Math.min(one.rows, other.rows);
  for (let row = 0; row < rows; row += 1) {
    /** @type {[string, (side: any) => any][]} */
    const fields = [
      ["action", ({ actions }) => (row === 0 ? NONE : actionNames.get(actions[row - 1]) ?? actions[row - 1])],
      ["reward", ({ rewards }) => reward(rewards[row])],
      ["episode", (side) => (side.isEnd(row) ? "ended" : "running")],
      ["level seed", ({ levelSeeds }) => levelSeeds[row]],
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
