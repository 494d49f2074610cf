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

  // Offers the level ranges of this pool and of others that play the same. `requestEpisodes(pool)` returns those of another pool.
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
      setOptions(byId("training-pool"), sources.map((source) => [source.name, `${rangeOf(source)} of ${source.name}`]));
    }
    if (sources.length > 0 && (isChanged || isOld)) {
      this.#choose();
    }
  }

  draw(episodes) {
    this.#episodes = episodes;
    const isOffered = this.#sources.has(byId("training-pool").value);
    byId("level-sets").hidden = !isOffered;
    if (!isOffered) {
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
    const others = chosen.name === this.#pool.name ? [] : await this.#requestEpisodes(chosen);
    if (chosen.name === this.#chosen?.name) {
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
