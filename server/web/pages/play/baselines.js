// Mean returns to compare with, by game and mode: of a random agent (docs/game_facts.json) and, on all levels, of the PPO
// runs that OpenAI published, after 25 million steps on 200 easy levels (clients/python/learners/results/openai_ppo.csv).

const BASELINE_NAMES = ["random agent", "PPO, 25 million steps"];
export const BASELINES = {
  bigfish: { easy: [0.84, 4.72], hard: [0.18] },
  bossfight: { easy: [0.05, 7.54], hard: [0.04] },
  caveflyer: { easy: [2.65, 5.36], hard: [1.50] },
  chaser: { easy: [0.67, 5.64], hard: [0.66] },
  climber: { easy: [2.25, 5.76], hard: [1.41] },
  coinrun: { easy: [2.77, 8.65], hard: [2.52] },
  dodgeball: { easy: [0.69, 1.86], hard: [0.63] },
  fruitbot: { easy: [-2.55, 26.67], hard: [-0.72] },
  heist: { easy: [3.10, 2.74], hard: [1.81] },
  jumper: { easy: [3.38, 5.71], hard: [0.89] },
  leaper: { easy: [2.43, 5.60], hard: [1.06] },
  maze: { easy: [4.47, 5.53], hard: [3.07] },
  miner: { easy: [1.23, 9.40], hard: [1.17] },
  ninja: { easy: [2.62, 5.82], hard: [1.18] },
  plunder: { easy: [4.31, 4.56], hard: [2.87] },
  starpilot: { easy: [1.53, 23.80], hard: [0.86] },
};

// The baselines of a game and mode, as [name, value].
export function baselinesOf(game, mode) {
  return (BASELINES[game]?.[mode] ?? []).map((value, i) => [BASELINE_NAMES[i], value]);
}
