// The frames of a replay: one for each row, which after an episode shows its end, and one for the start of each next episode.

export class Frames {
  #frames = [];  // { row, isStart }
  #ofRow = [];   // the index of a row's first frame

  // `recording`: of the replay.
  constructor({ rows, starts: all }) {
    const starts = new Set(all.filter((row) => row > 0 && row < rows - 1));
    for (let row = 0; row < rows; row += 1) {
      this.#ofRow.push(this.#frames.length);
      this.#frames.push({ row, isStart: row === 0 });
      if (starts.has(row)) {
        this.#frames.push({ row, isStart: true });
      }
    }
  }

  get last() {
    return this.#frames.length - 1;
  }

  at(index) {
    return this.#frames[index];
  }

  ofRow(row) {
    return this.#ofRow[row];
  }
}
