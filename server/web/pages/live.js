// The live view: follows the server's pools and opens the one in the URL, or else the first.

import { byId, element, setText, setTiles } from "./elements/elements.js";
import { count, milliseconds, rate, reward } from "./elements/figures.js";
import { notify } from "./elements/notices.js";
import { tellOptions } from "./links/level_choice.js";
import { EnlargedView } from "./live/enlarged.js";
import { Episodes } from "./live/episodes.js";
import { Mosaic } from "./live/mosaic.js";
import { LearnerPause } from "./live/pause.js";
import { Plots } from "./live/plots.js";
import { labelsOf, PoolTable, stateOf, titleOf } from "./live/pools.js";
import { Reports } from "./live/reports.js";
import { keepSettings } from "./live/settings.js";
import { loseReports, openPage, regainReports } from "./page.js";

let connection = null;
let catalog = null;
let open = null;     // the name of the open pool
let last = null;     // the last report
let shown = null;    // the pool opened last: { name, createTimeS }

keepSettings();
const enlarged = new EnlargedView((isOpen) => mosaic.cover(isOpen), writeEnvironment);
const mosaic = new Mosaic((pool, environment) => enlarged.show(connection, catalog, pool, environment));
const plots = new Plots(byId("plots"));
const episodes = new Episodes();
const pause = new LearnerPause(byId("pool-pause"), byId("large-pause"));
const reports = new Reports(receive, (error) => {
  drawUnknown();
  loseReports(error);
});
const table = new PoolTable(follow, (names) => plots.compare(names));

function ready(hello, opened) {
  connection = opened;
  open = null;
  catalog = hello.catalog;
  setText(byId("address"), hello.address);
  byId("token-hint").hidden = !hello.requiresToken;
  reports.start(connection);
}

function lost() {
  reports.stop();
  connection = null;
  open = null;
  mosaic.stop();
  enlarged.close();
  pause.lose();
  drawUnknown();
}

function receive(report) {
  regainReports();
  last = report;
  show();
}

// Shows the last report.
function show() {
  if (!last || !connection) {
    return;
  }
  drawServer(last.load);
  const pools = visiblePools();
  byId("empty").hidden = pools.length > 0;
  // The load counts the pools of all owners.
  const hasOthers = !byId("token-hint").hidden && last.load.poolCount > 0;
  setText(byId("empty-title"), hasOthers ? "No pools of your token yet" : "No pools yet");
  byId("bench").hidden = pools.length === 0;
  tellIfClosed();
  const wanted = new URLSearchParams(location.search).get("pool");
  const pool = chosenPool(wanted, pools);
  if (last.isFirst && wanted === null) {
    return;  // Which pool is being stepped is known after the second report.
  }
  byId("pool").hidden = !pool;
  byId("missing").hidden = Boolean(pool) || wanted === null;
  setText(byId("missing-name"), wanted ?? "");
  if ((pool?.name ?? null) !== open) {
    openPool(pool);
  }
  table.draw(pools, last.timeS, open);
  pause.follow(connection, pool ?? null);
  if (pool) {
    drawPool(pool);
    plots.add(pools);
    episodes.follow(pool);
  }
}

function named(text) {
  return visiblePools().find(({ name }) => name === text);
}

// Reports that the shown pool is gone, also if another one has its name.
function tellIfClosed() {
  const now = shown && named(shown.name);
  if (shown && now?.createTimeS !== shown.createTimeS) {
    notify(`${shown.name} was closed, and its history is gone.${now ? " This is another pool of the same name." : ""}`, "warn");
    shown = null;
    open = null;
  }
}

// The pool in the URL and no other; without one there the open pool, else one that is being stepped.
function chosenPool(wanted, pools) {
  return wanted === null ? named(open) ?? pools.find((pool) => stateOf(pool, last.timeS).rank === 0) ?? pools[0] : named(wanted);
}

// Shows that states and rates are not known.
function drawUnknown() {
  if (!last) {
    return;
  }
  const unknown = (pool) =>
    ({ ...pool, isUnknown: true, stepsPerSecond: null, requestP50Ms: null, requestP99Ms: null });
  drawServer({ ...last.load, stepsPerSecond: null });
  table.draw(visiblePools().map(unknown), last.timeS, shown?.name ?? null);
  const pool = shown && named(shown.name);
  if (pool) {
    drawPool(unknown(pool));
  }
  plots.lose();
}

// Pools of learners, without those created by pages.
function visiblePools() {
  return last.pools.filter(({ kind }) => kind === "pool");
}

// The pools of pages do not count.
function drawServer(load) {
  const ofPages = last.pools.filter(({ kind }) => kind !== "pool");
  const envCount = ofPages.reduce((sum, pool) => sum + pool.envCount, 0);
  const list = byId("server");
  list.hidden = false;
  setTiles(list, [
    ["Steps / s", rate(load.stepsPerSecond)], ["Pools", count(load.poolCount - ofPages.length)],
    ["Environments", count(load.envCount - envCount)],
    ["Workers", count(load.workerCount), "Threads that step environments"], ["Steps so far", rate(load.stepCount)],
  ]);
}

// Opens a pool in this page, unless the link opens in another tab.
function follow(event) {
  if (event.ctrlKey || event.metaKey || event.shiftKey) {
    return;
  }
  event.preventDefault();
  history.pushState(null, "", event.currentTarget.href);
  show();
  byId("pool").focus({ preventScroll: true });
}

function openPool(pool) {
  open = pool?.name ?? null;
  shown = pool ? { name: pool.name, createTimeS: pool.createTimeS } : shown;
  document.title = `${pool ? titleOf(pool) : "Live"} – Procgen Server`;
  enlarged.close();
  mosaic.open(connection, pool);
  plots.open(connection, catalog, pool);
  episodes.open(connection, pool);
  enlargeFromUrl(pool);
}

function enlargeFromUrl(pool) {
  const wanted = new URLSearchParams(location.search).get("environment");
  if (!pool || wanted === null) {
    return;
  }
  if (/^\d+$/.test(wanted) && Number(wanted) < pool.envCount) {
    enlarged.show(connection, catalog, pool, Number(wanted));
  } else {
    notify(`${pool.name} has no environment “${wanted}”: environments are 0 to ${pool.envCount - 1}.`, "bad");
  }
}

// Puts the enlarged environment into the URL; null: there is none.
function writeEnvironment(environment) {
  const url = new URL(location.href);
  if (environment === null) {
    url.searchParams.delete("environment");
  } else {
    url.searchParams.set("pool", open);
    url.searchParams.set("environment", environment);
  }
  history.replaceState(null, "", url);
}

function drawPool(pool) {
  setText(byId("pool-name"), titleOf(pool));
  const { text, kind } = stateOf(pool, last.timeS);
  setText(byId("pool-state"), text);
  byId("pool-state").className = `badge ${kind}`;
  const chosen = tellOptions(pool.options, catalog);
  const owner = pool.owner ? [`owner ${pool.owner}`] : [];
  byId("pool-labels").replaceChildren(...labelsOf(pool).map((label) => element("span", { class: "badge" }, label)));
  const name = pool.displayName ? [pool.name] : [];
  setText(byId("pool-about"), [...name, pool.games.join(", "), pool.mode, ...owner, ...chosen].join(" · "));
  setTiles(byId("pool-figures"), [
    ["Steps / s", rate(pool.stepsPerSecond)], ["Mean return", reward(pool.meanReturn), "Score of the last 100 episodes"],
    ["Mean length", count(pool.meanLength), "Steps of the last 100 episodes"], ["Episodes", count(pool.episodeCount)],
    ["Environments", count(pool.envCount)], ["Request p50", milliseconds(pool.requestP50Ms), "Median latency of the last 512 requests"],
    ["Request p99", milliseconds(pool.requestP99Ms), "99th percentile latency of the last 512 requests"], ["Steps so far", rate(pool.stepCount)],
  ]);
}

addEventListener("popstate", () => {
  open = null;
  show();
});
openPage(ready, lost, drawUnknown);
