// PoolSpecs of the pools that a page runs.

import { optionsMessage } from "./options.js";

const AUTORESET_MODE_NEXT_STEP = 2;
const ENCODING_DELTA_ZSTD = 2;

// Pools of `envCount` environments that play a level: { game, mode, level, options }. `isOnly`: the mode has no other level.
export function levelSpec({ game, mode, level, options = {} }, isOnly, envCount = 1) {
  const chosen = isOnly ? {} : { num_levels: 1, start_level: level };
  return { ...environmentSpec([game], mode, { ...options, ...chosen, rand_seed: 0 }), envCount };
}

// The pool of environment `environment` of `envCount`. It behaves as that one of the whole.
export function sliceSpec({ games, mode, options, envCount, environment }) {
  return { ...environmentSpec(games, mode, options), firstEnv: environment, totalEnvCount: envCount };
}

function environmentSpec(games, mode, options) {
  return {
    games, envCount: 1, options: optionsMessage(mode, options), autoresetMode: AUTORESET_MODE_NEXT_STEP, encoding: ENCODING_DELTA_ZSTD,
  };
}
