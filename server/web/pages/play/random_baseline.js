// Mean returns of a random agent, by game and mode. Source: the table of envcore/README.md, which procgen-random-baseline prints.

export const RANDOM_BASELINE = {
  bigfish: { easy: 0.83, hard: 0.21 },
  bossfight: { easy: 0.05, hard: 0.04 },
  caveflyer: { easy: 2.83, hard: 1.48 },
  chaser: { easy: 0.65, hard: 0.64 },
  climber: { easy: 2.18, hard: 1.29 },
  coinrun: { easy: 2.62, hard: 2.44 },
  dodgeball: { easy: 0.65, hard: 0.69 },
  fruitbot: { easy: -2.48, hard: -0.68 },
  heist: { easy: 3.06, hard: 1.71 },
  jumper: { easy: 3.28, hard: 1.01 },
  leaper: { easy: 2.54, hard: 1.01 },
  maze: { easy: 4.21, hard: 3.00 },
  miner: { easy: 1.26, hard: 1.21 },
  ninja: { easy: 2.53, hard: 1.23 },
  plunder: { easy: 4.29, hard: 3.02 },
  starpilot: { easy: 1.57, hard: 0.85 },
};
