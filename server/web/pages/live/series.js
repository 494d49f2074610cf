// The time series of a pool: the server's history, and the events since.

// Rows are objects with the members of the history, and `game_returns`: mean return by game, if the pool has several.
export class Series {
  pool;
  games = [];
  rows = [];
  #columns = ["time_s"];
  #spanS = 0;
  #isBegun = false;

  constructor(pool) {
    this.pool = pool;
  }

  // Starts with an answer of pool.history over `spanS` seconds.
  begin({ columns, games, rows }, spanS) {
    this.#columns = columns;
    this.#spanS = spanS;
    this.games = games;
    this.rows = rows.map((row) => ({
      ...Object.fromEntries(columns.map((name, index) => [name, row[index]])),
      game_returns: Object.fromEntries(games.map((game, index) => [game, row[columns.length + index]])),
    }));
    this.#isBegun = true;
  }

  // Adds the pool's values of the event at `time`.
  add(pool, time) {
    if (this.#isBegun && time > (this.rows.at(-1)?.time_s ?? 0)) {
      this.rows.push({ ...pool, time_s: time });
      while (this.rows[0].time_s < time - this.#spanS) {
        this.rows.shift();
      }
    }
  }

  // Adds a row without values: a gap in the lines.
  lose() {
    if (this.rows.length > 0) {
      this.rows.push({ time_s: this.rows.at(-1).time_s + 1 });
    }
  }

  // The rows as lines of CSV, without a header.
  toCsv() {
    return this.rows.map((row) => [
      this.pool.name, new Date(row.time_s * 1000).toISOString(),
      ...this.#columns.slice(1).map((name) => row[name] ?? ""), ...this.games.map((game) => row.game_returns?.[game] ?? ""),
    ].join(","));
  }

  get csvHeader() {
    return ["pool", "time", ...this.#columns.slice(1), ...this.games.map((game) => `mean_return_${game}`)].join(",");
  }
}
