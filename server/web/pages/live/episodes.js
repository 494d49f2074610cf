// The last episodes of the open pool: a sorted table from which they are replayed, and charts.

import { byId, element, setText } from "../elements/elements.js";
import { clock, count, plural, rate, reward } from "../elements/figures.js";
import { SortedHeader } from "../elements/tables.js";
import { secondsOf } from "../connection/times.js";
import { attempt } from "../page.js";
import { fingerprintText } from "../run/environment.js";
import { BarChart, levelBins, returnBins } from "./episode_charts.js";
import { openEpisode } from "./open_episode.js";

const KEPT_MAX = 1000;
const SHOWN_COUNT = 25;
const INTERVAL_MS = 5000;

const COLUMNS = [
  { title: "Ended", isNumber: true, value: ({ number }) => number, write: ({ endTimeS: time }) => clock(time) },
  { title: "Return", isNumber: true, value: ({ totalReward: value }) => value, write: (episode) => reward(episode.totalReward) },
  { title: "Recording", value: ({ isKept }) => (isKept ? "kept" : "lost") },
  { title: "Length", isNumber: true, value: ({ length }) => length, write: ({ length }) => count(length) },
  { title: "Level seed", isNumber: true, value: ({ levelSeed: seed }) => seed, write: (episode) => String(episode.levelSeed) },
  { title: "Game", value: ({ game }) => game, write: ({ game }) => game },
  { title: "End", value: (episode) => endOf(episode), write: (episode) => endOf(episode) },
  { title: "Environment", isNumber: true, value: ({ environment }) => environment, write: (episode) => String(episode.environment) },
];

function endOf({ levelComplete: isComplete, truncated }) {
  return isComplete ? "completed" : truncated ? "time limit" : "failed";
}

export class Episodes {
  #connection = null;
  #pool = null;
  #episodes = [];     // oldest first
  #count = 0;         // episodes of the pool that were requested
  #recordedFrom = 1;  // number of the oldest with a recording
  #requestTime = -INTERVAL_MS;
  #isBusy = false;
  #shown = SHOWN_COUNT;
  #header = new SortedHeader(byId("episode-columns"), COLUMNS, "Ended", true, () => this.#drawRows());
  #returns = new BarChart(byId("episode-charts"), "Returns", reward, count);
  #levels = new BarChart(byId("episode-charts"), "Mean return by level seed", rate, reward);

  constructor() {
    byId("episodes-more").addEventListener("click", () => {
      this.#shown += SHOWN_COUNT;
      this.#drawRows();
    });
  }

  // Shows the episodes of a pool; null: none.
  open(connection, pool) {
    this.#connection = connection;
    this.#pool = pool ?? null;
    this.#episodes = [];
    this.#count = 0;
    this.#requestTime = -INTERVAL_MS;
    this.#shown = SHOWN_COUNT;
    this.#draw();
    this.#drawRows();
  }

  // Requests what has ended since the last request. `pool`: of the newest report.
  async follow(pool) {
    const isDue = performance.now() - this.#requestTime >= INTERVAL_MS;
    if (!this.#connection || this.#isBusy || !isDue || document.hidden || pool.episodeCount === this.#count) {
      return;
    }
    this.#isBusy = true;
    this.#requestTime = performance.now();
    const list = await attempt(() => this.#connection.call("PoolService.ListEpisodes", { pool: pool.name, after: BigInt(this.#count) }), () => {});
    this.#isBusy = false;
    if (!list || pool.name !== this.#pool?.name || pool.createTimeS !== this.#pool.createTimeS) {
      return;
    }
    this.#count = Number(list.episodeCount);
    this.#recordedFrom = Number(list.episodeCount - list.recordedCount) + 1;
    this.#episodes = [...this.#episodes, ...episodesOf(list, pool)].slice(-KEPT_MAX);
    this.#draw();
    // Rows stay where they are while the user is about to press one.
    if (!byId("episode-rows").matches(":hover, :focus-within")) {
      this.#drawRows();
    }
  }

  #draw() {
    const isEmpty = this.#episodes.length === 0;
    byId("episodes-content").hidden = isEmpty;
    setText(byId("episodes-about"), isEmpty ? "No episode has ended yet."
      : `The last ${plural(this.#episodes.length, "episode")} of ${count(this.#count)}.`
        + (this.#recordedFrom > this.#episodes[0].number ? " The recordings of the older ones are gone." : ""));
    setText(byId("episodes-problem"), "");
    if (!isEmpty) {
      this.#returns.draw(returnBins(this.#episodes));
      this.#levels.draw(levelBins(this.#episodes));
    }
  }

  #drawRows() {
    const newest = new Map(this.#episodes.map(({ environment, number }) => [environment, number]));
    this.#episodes.forEach((episode) => {
      episode.isKept = episode.number >= this.#recordedFrom || newest.get(episode.environment) === episode.number;
    });
    // Of equals, the newest first.
    const sorted = this.#header.sort([...this.#episodes].reverse());
    byId("episode-rows").replaceChildren(...sorted.slice(0, this.#shown).map((episode) => element("tr", {},
      ...COLUMNS.map(({ isNumber, write }) =>
        element("td", { class: isNumber ? "number" : null }, write ? write(episode) : this.#makeRecording(episode))))));
    byId("episodes-more").hidden = sorted.length <= this.#shown;
  }

  #makeRecording(episode) {
    const { environment, levelSeed: seed, isKept } = episode;
    if (!isKept) {
      return element("span", { class: "quiet", title: "The server keeps recordings of the last episodes" }, "gone");
    }
    return element("button", {
      type: "button", onclick: () => this.#replay(episode),
      "aria-label": `Replay the episode of environment ${environment} in level ${seed}`,
    }, "Replay");
  }

  async #replay({ environment, fingerprint }) {
    const say = (text) => setText(byId("episodes-problem"), text);
    say("");
    await attempt(() => openEpisode(this.#connection, { pool: this.#pool.name, environment, episode: fingerprint }), say);
  }
}

// The episodes of ListEpisodesResponse, with the game and the number of each.
function episodesOf({ episodes, episodeCount }, { games, firstEnv: first }) {
  const before = Number(episodeCount) - episodes.length;
  return episodes.map((episode, i) => ({
    number: before + i + 1, endTimeS: secondsOf(episode.endTime), environment: episode.environment, levelSeed: episode.levelSeed,
    totalReward: episode.totalReward, length: episode.length, levelComplete: episode.levelComplete, truncated: episode.truncated,
    fingerprint: fingerprintText(episode.fingerprint), game: games[(first + episode.environment) % games.length],
  }));
}
