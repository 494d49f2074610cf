// Actions and results of one environment, by row. Row 0 is the state before the first action.

export class Recording {
  games;
  mode;
  options;     // by name
  actions = [];
  rewards = [];
  first = [];  // an episode begins: at row 0, and where one has ended
  levelSeeds = [];
  prevLevelSeeds = [];
  prevLevelComplete = [];
  #returns = [];
  #lengths = [];
  #ends = [];  // { row, fingerprint } of finished episodes

  // `start`: the row of the state before the first action.
  constructor({ games, mode, options }, start) {
    this.games = games;
    this.mode = mode;
    this.options = options;
    this.#push(start, true, start.levelSeed);
  }

  get rows() {
    return this.rewards.length;
  }

  // Adds the row of an action. `next`: after the end of an episode, the row that began the next one; else null.
  add(action, row, next) {
    this.actions.push(action);
    if (next) {
      this.#ends.push({ row: this.rows, fingerprint: row.fingerprint });
    }
    this.#push(row, next !== null, (next ?? row).levelSeed);
  }

  #push(row, isFirst, levelSeed) {
    this.rewards.push(row.reward);
    this.first.push(isFirst);
    this.levelSeeds.push(levelSeed);
    this.prevLevelSeeds.push(row.prevLevelSeed);
    this.prevLevelComplete.push(row.prevLevelComplete);
    this.#returns.push(row.episodeReturn);
    this.#lengths.push(row.episodeLength);
  }

  // Removes all rows but the first `rows`, at least 1.
  truncate(rows) {
    this.actions.length = rows - 1;
    for (const column of [this.rewards, this.first, this.levelSeeds, this.prevLevelSeeds, this.prevLevelComplete, this.#returns, this.#lengths]) {
      column.length = rows;
    }
    this.#ends = this.#ends.filter(({ row }) => row < rows);
  }

  // The rows where an episode begins.
  get starts() {
    return this.first.flatMap((isFirst, row) => (isFirst ? [row] : []));
  }

  // Whether an episode ended with the action that led to a row.
  isEnd(row) {
    return row > 0 && this.first[row];
  }

  // The first row of the level that is shown at a row.
  levelStart(row) {
    let start = row;
    while (start > 0 && !this.first[start] && !this.prevLevelComplete[start]) {
      start -= 1;
    }
    return start;
  }

  // The rows where the level changes: [row, seed].
  get levelChanges() {
    return this.levelSeeds.flatMap((seed, row) => (row === 0 || seed !== this.levelSeeds[row - 1] ? [[row, seed]] : []));
  }

  // The fingerprints of all finished episodes.
  get fingerprints() {
    return this.#ends.map(({ fingerprint }) => fingerprint);
  }

  // What a page shows of a row: of the episode that just ended, or else of the current one.
  viewOf(row) {
    const ends = this.#ends.filter((end) => end.row <= row);
    return {
      step: row, reward: this.rewards[row], totalReward: this.#returns[row], first: this.first[row], levelSeed: this.levelSeeds[row],
      prevLevelSeed: this.prevLevelSeeds[row], prevLevelComplete: this.prevLevelComplete[row], episodeCount: ends.length,
      episodeStep: this.#lengths[row], fingerprint: ends.at(-1)?.fingerprint ?? null,
    };
  }

  get fileName() {
    return `${this.games.join("-")}.${this.mode}.${this.levelSeeds[0]}.trace`;
  }
}
