// The catalog as pages use it: modes and types by name, numbers in place of bigints.

import { nameOfMode } from "../run/options.js";

const BOOLEAN = 1;  // OptionType
const NAME = 3;
// Options that select levels; pages use the seed instead.
const BY_SEED = ["distribution_mode", "num_levels", "start_level", "rand_seed"];

export function catalogOf({ games, options, actions }) {
  return {
    games: games.map(({ name, description, modes, specialActions, variants }) => ({
      name, description, specialActions, variants: variants.map((variant) => variant.name),
      modes: modes.map(({ distributionMode, returnRange, levelSeed }) => ({ name: nameOfMode(distributionMode), returnRange, levelSeed })),
    })),
    options: options.filter(({ name }) => !BY_SEED.includes(name)).map(({ name, description, type, defaultValue, min, max }) => ({
      name, description,
      ...type === BOOLEAN ? { type: "boolean", default: defaultValue === "true" }
        : type === NAME ? { type: "name", default: defaultValue }
        : { type: "integer", min: Number(min), max: Number(max), default: Number(defaultValue) },
    })),
    actions,
  };
}
