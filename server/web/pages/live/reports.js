// The server's pools and load, requested every second.

import { LOST, UserError } from "../connection/errors.js";
import { poolOf } from "./pool_model.js";
import { Rates } from "./rates.js";

const INTERVAL_MS = 1000;
const FIRST_INTERVAL_MS = 300;  // rates need two reports
const IN_FLIGHT_MAX = 3;

// A report is { timeS, load, pools, isFirst }.
export class Reports {
  #connection = null;
  #timer = null;
  #isFirst = true;
  #inFlight = 0;
  #rates = new Rates();
  #onReport;
  #onError;

  // `onReport(report)` is called with each report, `onError(error)` if the server does not answer with one.
  constructor(onReport, onError) {
    this.#onReport = onReport;
    this.#onError = onError;
  }

  start(connection) {
    this.stop();
    this.#connection = connection;
    this.#isFirst = true;
    this.#rates = new Rates();
    this.#poll();
  }

  stop() {
    clearTimeout(this.#timer);
    this.#connection = null;
  }

  // Requests a report every second. On a slow line some are on their way at the same time.
  async #poll() {
    const connection = this.#connection;
    this.#timer = setTimeout(() => this.#poll(), this.#isFirst ? FIRST_INTERVAL_MS : INTERVAL_MS);
    if (this.#inFlight >= IN_FLIGHT_MAX) {
      return;
    }
    this.#inFlight += 1;
    try {
      const [pools, load] = await Promise.all([listPools(connection), connection.call("CatalogService.GetLoad")]);
      if (connection === this.#connection) {
        this.#report(pools.map(poolOf), load);
        this.#isFirst = false;
      }
    } catch (error) {
      if (!(error instanceof UserError)) {
        throw error;
      }
      if (connection === this.#connection && error.code !== LOST) {
        this.#onError(error);
      }
    } finally {
      this.#inFlight -= 1;
    }
  }

  #report(pools, load) {
    const timeS = Date.now() / 1000;
    this.#onReport({
      timeS, isFirst: this.#isFirst,
      load: { ...load, stepsPerSecond: this.#rates.add("", Number(load.stepCount), timeS).perSecond, stepCount: Number(load.stepCount) },
      pools: pools.map((pool) => {
        const { perSecond, changeTimeS } = this.#rates.add(pool.name, pool.stepCount, timeS);
        const lastStepTimeS = pool.stepCount === 0 ? null : changeTimeS ?? undefined;  // of a known step; null: there was none
        return { ...pool, stepsPerSecond: perSecond, lastStepTimeS };
      }),
    });
  }
}

// All pools of the caller.
async function listPools(connection) {
  const pools = [];
  let pageToken = "";
  do {
    const page = await connection.call("PoolService.ListPools", { pageToken });
    pools.push(...page.pools);
    pageToken = page.nextPageToken;
  } while (pageToken !== "");
  return pools;
}
