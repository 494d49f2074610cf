// The time series of a pool: the server's history.

// Columns of a CSV file after the time, and members of rows.
const COLUMNS = [
  ["step_count", "stepCount"], ["steps_per_second", "stepsPerSecond"], ["episode_count", "episodeCount"], ["mean_return", "meanReturn"],
  ["mean_length", "meanLength"], ["request_p50_ms", "requestP50Ms"], ["request_p99_ms", "requestP99Ms"], ["return_min", "returnMin"],
  ["return_max", "returnMax"], ["return_deviation", "returnDeviation"],
];

// Rows are those of pool_model.js, oldest first.
export class Series {
  pool;
  rows = [];
  #spanS = 0;
  isBegun = false;

  constructor(pool) {
    this.pool = pool;
  }

  // The names of the pool's games, if there are several.
  get games() {
    return this.pool.gameNames;
  }

  // Starts with the history of the last `spanS` seconds.
  begin(rows, spanS) {
    this.#spanS = spanS;
    this.rows = rows;
    this.isBegun = true;
  }

  // Adds the rows that are newer.
  add(rows) {
    const last = this.rows.at(-1)?.timeS ?? 0;
    this.rows.push(...rows.filter(({ timeS }) => timeS > last));
    while (this.rows.length > 0 && this.rows[0].timeS < this.rows.at(-1).timeS - this.#spanS) {
      this.rows.shift();
    }
  }

  // Adds a row without values: a gap in the lines.
  lose() {
    if (this.rows.length > 0) {
      this.rows.push({ timeS: this.rows.at(-1).timeS + 1 });
    }
  }

  // The rows as lines of CSV, without a header.
  toCsv() {
    return this.rows.map((row) => [
      this.pool.name, new Date(row.timeS * 1000).toISOString(),
      ...COLUMNS.map(([, member]) => row[member] ?? ""), ...this.games.map((game) => row.gameReturns?.[game] ?? ""),
    ].join(","));
  }

  get csvHeader() {
    return ["pool", "time", ...COLUMNS.map(([name]) => name), ...this.games.map((game) => `mean_return_${game}`)].join(",");
  }
}
