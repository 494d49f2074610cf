// The form that chooses an episode of a pool for a comparison.

import { byId, setOptions } from "../elements/elements.js";
import { plural, reward } from "../elements/figures.js";
import { attempt } from "../page.js";
import { fingerprintText } from "../run/environment.js";
import { kindOf } from "../run/kinds.js";

const OFFERED_MAX = 200;

export class OtherEpisodes {
  #form = byId("other-pool");
  #current;

  // `current()` returns what the page shows: { connection, replay, place: of the episode or null }. `onChoose(place)` is called with the
  // episode to compare with.
  constructor(current, onChoose) {
    this.#current = current;
    const { pool, episode } = this.#form.elements;
    pool.addEventListener("change", () => this.#listEpisodes());
    this.#form.addEventListener("submit", (event) => {
      event.preventDefault();
      const [environment, fingerprint] = episode.value.split(" ");
      onChoose({ pool: pool.value, environment: Number(environment), episode: fingerprint });
    });
  }

  // Offers the pools that there are now, those of the same game first.
  async listPools() {
    const { connection, replay, place } = this.#current();
    const list = await attempt(() => connection.call("PoolService.ListPools"));
    if (!list) {
      return;
    }
    const plays = ({ spec }) => replay.source.games.every((game) => spec.games.includes(game));
    const pools = list.pools.filter(({ name }) => kindOf(name) === "pool")
      .sort((one, other) => Number(plays(other)) - Number(plays(one)));
    const { pool } = this.#form.elements;
    setOptions(pool, pools.map(({ name, spec }) => [name, `${spec.displayName || name}, ${spec.games.join(", ")}`]),
      pool.value || place?.pool);
    this.#form.hidden = pools.length === 0;
    await this.#listEpisodes();
  }

  // Offers the last episodes of the pool that have a recording: first those in the level that is shown.
  async #listEpisodes() {
    const { connection, replay } = this.#current();
    const { pool, episode } = this.#form.elements;
    const name = pool.value;
    const list = name && await attempt(() => connection.call("PoolService.ListEpisodes", { pool: name }));
    if (!list || name !== pool.value) {
      return;
    }
    const isHere = ({ levelSeed }) => levelSeed === replay.recording.levelSeeds[0];
    const recorded = list.episodes.slice(-Number(list.recordedCount)).reverse();
    const shown = [...recorded.filter(isHere), ...recorded.filter((each) => !isHere(each))].slice(0, OFFERED_MAX);
    setOptions(episode, shown.map((each) => [`${each.environment} ${fingerprintText(each.fingerprint)}`, [
      `level ${each.levelSeed}${isHere(each) ? " (this one)" : ""}`, `return ${reward(each.totalReward)}`, plural(each.length, "step"),
      `environment ${each.environment}`,
    ].join(", ")]));
  }
}
