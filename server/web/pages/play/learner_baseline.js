// Mean returns of the reference learner, PPO after 2 million steps on 200 easy levels, on all levels, by game and mode. Source: the
// column "test levels" in clients/python/learners/results/all_games-small/table.md.

export const LEARNER_BASELINE = {
  bigfish: { easy: 0.89 },
  bossfight: { easy: 0.34 },
  caveflyer: { easy: 4.30 },
  chaser: { easy: 0.92 },
  climber: { easy: 2.32 },
  coinrun: { easy: 7.30 },
  dodgeball: { easy: 1.28 },
  fruitbot: { easy: -2.06 },
  heist: { easy: 2.80 },
  jumper: { easy: 4.20 },
  leaper: { easy: 2.33 },
  maze: { easy: 4.70 },
  miner: { easy: 0.94 },
  ninja: { easy: 4.30 },
  plunder: { easy: 4.31 },
  starpilot: { easy: 3.61 },
};
