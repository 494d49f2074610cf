// The views of a replay by row, requested ahead of their use.

import { attempt } from "../page.js";

export class Rows {
  #replay;
  #sizePx;
  #views = new Map();  // row -> promise of its view

  // `replay`: a ReplayRun; `sizePx`: of the view for people.
  constructor(replay, sizePx) {
    this.#replay = replay;
    this.#sizePx = sizePx;
  }

  // Requests `rows` that are not requested yet and forgets all others. Resolves to the view of the first, or null after an error.
  async fetch(rows) {
    [...this.#views.keys()].filter((row) => !rows.includes(row)).forEach((row) => this.#views.delete(row));
    for (const row of rows) {
      if (!this.#views.has(row)) {
        this.#views.set(row, attempt(() => this.#replay.seek(row, this.#sizePx)));
      }
    }
    const view = await this.#views.get(rows[0]);
    if (!view) {
      this.#views.clear();
    }
    return view;
  }
}
