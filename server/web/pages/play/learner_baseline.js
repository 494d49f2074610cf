// Mean returns on all levels of the PPO runs that OpenAI published, after 25 million steps on 200 easy levels, by game and mode. Source:
// clients/python/learners/results/openai_ppo.csv.

export const LEARNER_BASELINE = {
  bigfish: { easy: 4.72 },
  bossfight: { easy: 7.54 },
  caveflyer: { easy: 5.36 },
  chaser: { easy: 5.64 },
  climber: { easy: 5.76 },
  coinrun: { easy: 8.65 },
  dodgeball: { easy: 1.86 },
  fruitbot: { easy: 26.67 },
  heist: { easy: 2.74 },
  jumper: { easy: 5.71 },
  leaper: { easy: 5.60 },
  maze: { easy: 5.53 },
  miner: { easy: 9.40 },
  ninja: { easy: 5.82 },
  plunder: { easy: 4.56 },
  starpilot: { easy: 23.80 },
};
