// Mean returns to compare with, by game and mode: of a random agent (docs/game_facts.json) and, on all levels, of the PPO
// runs that OpenAI published, after 25 million steps on 200 easy levels (clients/python/learners/results/openai_ppo.csv).

const BASELINE_NAMES = ["random agent", "PPO, 25 million steps"];
export const BASELINES = {
  bigfish: { easy: [0.83, 4.72], hard: [0.21] },
  bossfight: { easy: [0.05, 7.54], hard: [0.04] },
  caveflyer: { easy: [2.83, 5.36], hard: [1.48] },
  chaser: { easy: [0.65, 5.64], hard: [0.64] },
  climber: { easy: [2.18, 5.76], hard: [1.29] },
  coinrun: { easy: [2.62, 8.65], hard: [2.44] },
  dodgeball: { easy: [0.65, 1.86], hard: [0.69] },
  fruitbot: { easy: [-2.48, 26.67], hard: [-0.68] },
  heist: { easy: [3.06, 2.74], hard: [1.71] },
  jumper: { easy: [3.28, 5.71], hard: [1.01] },
  leaper: { easy: [2.54, 5.60], hard: [1.01] },
  maze: { easy: [4.21, 5.53], hard: [3.00] },
  miner: { easy: [1.26, 9.40], hard: [1.21] },
  ninja: { easy: [2.53, 5.82], hard: [1.23] },
  plunder: { easy: [4.29, 4.56], hard: [3.02] },
  starpilot: { easy: [1.57, 23.80], hard: [0.85] },
};

// The baselines of a game and mode, as [name, value].
export function baselinesOf(game, mode) {
  return (BASELINES[game]?.[mode] ?? []).map((value, i) => [BASELINE_NAMES[i], value]);
}
