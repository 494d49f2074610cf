// Episodes in training levels against episodes in other levels, which measures generalization.

import { byId, element, setOptions, setText } from "../elements/elements.js";
import { count, NONE, reward } from "../elements/figures.js";

const OTHERS_INTERVAL_MS = 60_000;

export class LevelSets {
  #pool = null;
  #sources = new Map();  // name -> pool with a limited number of levels
  #requestEpisodes = null;
  #episodes = [];        // of the open pool
  #others = [];          // of the chosen pool, if that is another one
  #othersTime = 0;       // when they were requested

  constructor() {
    byId("training-pool").addEventListener("change", () => this.#choose());
  }

  // Offers the training levels of this pool. Those of others that play the same can be chosen: only the user knows whether
  // the same agent plays there. `requestEpisodes(pool)` returns the episodes of another pool.
  offer(pool, pools, requestEpisodes) {
    const isOld = pool.name !== this.#pool?.name || performance.now() - this.#othersTime > OTHERS_INTERVAL_MS;
    this.#pool = pool;
    this.#requestEpisodes = requestEpisodes;
    const isSame = (other) => other.mode === pool.mode && other.games.join() === pool.games.join();
    const sources = [pool, ...pools.filter((other) => other.name !== pool.name && other.kind === "pool" && isSame(other))]
      .filter(({ options }) => options.num_levels > 0);
    const isChanged = sources.map(({ name }) => name).join() !== [...this.#sources.keys()].join();
    this.#sources = new Map(sources.map((source) => [source.name, source]));
    if (isChanged) {
      const none = sources[0]?.name === pool.name ? [] : [["", "Choose the pool that trains this agent"]];
      setOptions(byId("training-pool"), [...none, ...sources.map((source) => [source.name, this.#describe(source)])]);
    }
    if (sources.length > 0 && (isChanged || isOld)) {
      this.#choose();
    }
  }

  #describe(source) {
    return source.name === this.#pool.name ? rangeOf(source) : `${rangeOf(source)} of ${source.name}, with its episodes`;
  }

  draw(episodes) {
    this.#episodes = episodes;
    byId("level-sets").hidden = this.#sources.size === 0;
    byId("level-sets-table").hidden = !this.#chosen;
    if (!this.#chosen) {
      setText(byId("level-sets-about"), "");
      return;
    }
    const { start_level: start, num_levels: levels } = this.#chosen.options;
    const isTraining = ({ levelSeed: seed }) => seed >= start && seed < start + levels;
    const all = [...episodes, ...this.#others];
    const sets = [["Training levels", all.filter(isTraining)], ["Unseen levels", all.filter((episode) => !isTraining(episode))]];
    byId("level-set-rows").replaceChildren(...sets.map(([title, set]) => element("tr", {},
      element("th", { scope: "row" }, title), ...summaryOf(set).map((text) => element("td", { class: "number" }, text)))));
    const names = [this.#pool.name, ...this.#chosen.name === this.#pool.name ? [] : [this.#chosen.name]];
    setText(byId("level-sets-about"), `Episodes of ${names.join(" and ")}.`);
  }

  get #chosen() {
    return this.#sources.get(byId("training-pool").value);
  }

  async #choose() {
    this.#othersTime = performance.now();
    const chosen = this.#chosen;
    const others = !chosen || chosen.name === this.#pool.name ? [] : await this.#requestEpisodes(chosen);
    if (chosen?.name === this.#chosen?.name) {
      this.#others = others;
      this.draw(this.#episodes);
    }
  }
}

function rangeOf({ options: { start_level: start, num_levels: levels } }) {
  return `levels ${start} to ${start + levels - 1}`;
}

// Episodes, mean return, and the share that completed its level.
function summaryOf(episodes) {
  const mean = (values) => (values.length === 0 ? null : values.reduce((sum, value) => sum + value, 0) / values.length);
  const share = mean(episodes.map(({ levelComplete: isComplete }) => Number(isComplete)));
  return [
    count(episodes.length), reward(mean(episodes.map(({ totalReward: value }) => value))),
    share === null ? NONE : `${Math.round(100 * share)}%`,
  ];
}
