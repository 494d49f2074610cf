// The rows of a replay that is open on the server, requested ahead of their use.

import { attempt } from "../page.js";

export class Rows {
  #connection;
  #number;
  #views = new Map();  // row -> promise of its view

  // `replay`: the answer of replay.open.
  constructor(connection, { replay }) {
    this.#connection = connection;
    this.#number = replay;
  }

  // Requests `rows` that are not requested yet and forgets all others. Resolves to the view of the first, or null after an error.
  async fetch(rows) {
    [...this.#views.keys()].filter((row) => !rows.includes(row)).forEach((row) => this.#views.delete(row));
    for (const row of rows) {
      if (!this.#views.has(row)) {
        this.#views.set(row, attempt(() => this.#connection.call("replay.seek", { replay: this.#number, row })));
      }
    }
    const view = await this.#views.get(rows[0]);
    if (!view) {
      this.#views.clear();
    }
    return view;
  }

  // Closes the replay on the server.
  close() {
    this.#connection.call("replay.close", { replay: this.#number }).catch(() => {});
  }
}
