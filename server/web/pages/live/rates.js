// Rates of counters that are read again and again.

const WINDOW_S = 10;

export class Rates {
  #reads = new Map();  // name -> { values: [time, count] of the last ten seconds, changeTimeS }

  // Adds a read of a counter at a time in seconds. Returns { perSecond: over the last ten seconds, or null after the first read;
  // changeTimeS: when the counter changed last, or null if it has not since the first read }.
  add(name, count, timeS) {
    const { values, changeTimeS } = this.#reads.get(name) ?? { values: [], changeTimeS: null };
    const before = values.at(-1)?.[1];
    const kept = [...values.filter(([time]) => time > timeS - WINDOW_S && time < timeS), [timeS, count]];
    const changed = before !== undefined && count !== before ? timeS : changeTimeS;
    this.#reads.set(name, { values: kept, changeTimeS: changed });
    const [[since, old]] = kept;
    return { perSecond: kept.length < 2 ? null : (count - old) / (timeS - since), changeTimeS: changed };
  }
}
