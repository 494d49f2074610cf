// The last hour of each pool: its mean returns, and when it was stepped last.

import { secondsOf } from "../connection/times.js";

const SPAN_S = 3600n;
const AGAIN_MS = 60_000;
const SOON_MS = 5000;  // as long as there are no returns
const RETURNS_MAX = 60;

export class LastHours {
  #hours = new Map();  // name -> { createTimeS, requested: by performance.now(), returns, lastStepTimeS, stepCount }
  #isBusy = false;
  clockOffsetS = 0;    // the server's clock minus the browser's

  returnsOf({ name }) {
    return this.#hours.get(name)?.returns ?? [];
  }

  // When the steps of a pool were taken, at the latest; undefined if that is not known yet.
  lastStepTimeOf({ name, stepCount }) {
    const hour = this.#hours.get(name);
    return hour?.stepCount === stepCount ? hour.lastStepTimeS : undefined;
  }

  // Requests the histories that are missing or a minute old, one after the other. `pools`: messages.
  async request(connection, pools) {
    const names = new Set(pools.map(({ name }) => name));
    [...this.#hours.keys()].filter((name) => !names.has(name)).forEach((name) => this.#hours.delete(name));
    if (this.#isBusy || document.hidden) {
      return;
    }
    this.#isBusy = true;
    for (const pool of pools) {
      const requested = this.#hours.get(pool.name)?.requested;
      if (requested === undefined || performance.now() - requested > AGAIN_MS) {
        const history = await connection.call("PoolService.GetPoolHistory", { name: pool.name, span: { seconds: SPAN_S } }).catch(() => null);
        this.#take(pool.name, history);
      }
    }
    this.#isBusy = false;
  }

  #take(name, history) {
    const rows = history?.rows ?? [];
    const hasReturns = rows.some(({ meanEpisodeReturn }) => meanEpisodeReturn !== undefined);
    const requested = performance.now() - (hasReturns ? 0 : AGAIN_MS - SOON_MS);
    if (rows.length === 0) {
      this.#hours.set(name, { requested, returns: [] });
      return;
    }
    const newest = rows.at(-1);
    this.clockOffsetS = secondsOf(newest.time) - Date.now() / 1000;
    const stride = Math.max(1, Math.ceil(rows.length / RETURNS_MAX));
    const shown = rows.filter((_, i) => (rows.length - 1 - i) % stride === 0);
    this.#hours.set(name, {
      requested, returns: shown.map(({ meanEpisodeReturn: value }) => value ?? null), stepCount: Number(newest.stepCount),
      lastStepTimeS: secondsOf(rows.find(({ stepCount }) => stepCount === newest.stepCount).time),
    });
  }
}
