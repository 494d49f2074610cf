// The live view: follows the server's pools and opens the one in the URL, or else the first.

import { byId, setText, setTiles } from "./elements/elements.js";
import { count, milliseconds, rate, reward } from "./elements/figures.js";
import { notify } from "./elements/notices.js";
import { tellOptions } from "./links/level_choice.js";
import { EnlargedView } from "./live/enlarged.js";
import { Episodes } from "./live/episodes.js";
import { Mosaic } from "./live/mosaic.js";
import { NodeTable } from "./live/nodes.js";
import { LearnerPause } from "./live/pause.js";
import { Plots } from "./live/plots.js";
import { PoolTable, stateOf } from "./live/pools.js";
import { attempt, openPage } from "./page.js";

let connection = null;
let catalog = null;
let self = null;     // the server's node name
let open = null;     // the name of the open pool
let last = null;     // the last event "pools"
let shown = null;    // the pool opened last: { name, create_time_s }

const enlarged = new EnlargedView((isOpen) => mosaic.cover(isOpen), writeEnvironment);
const mosaic = new Mosaic((pool, environment) => enlarged.show(connection, catalog, pool, environment));
const nodes = new NodeTable(byId("node-rows"));
const plots = new Plots(byId("plots"));
const episodes = new Episodes();
const pause = new LearnerPause(byId("pool-pause"), byId("large-pause"));
const table = new PoolTable(follow, (names) => plots.compare(names));

async function ready(hello, opened) {
  connection = opened;
  open = null;
  catalog = hello.catalog;
  self = hello.node;
  byId("token-hint").hidden = !hello.requires_token;
  byId("nodes").hidden = !hello.cluster;
  opened.expectsEvents = (await attempt(() => opened.call("pools.follow"))) !== null;
}

function lost() {
  connection = null;
  open = null;
  mosaic.stop();
  enlarged.close();
  pause.lose();
  drawUnknown();
}

function receive(event) {
  last = event;
  if (!byId("nodes").hidden) {
    nodes.draw(event.nodes, event.time_s);
  }
  show();
}

// Shows the last event.
function show() {
  if (!last || !connection) {
    return;
  }
  drawServer(last.server.load);
  const pools = visiblePools();
  byId("empty").hidden = pools.length > 0;
  // The load counts the pools of all owners.
  const hasOthers = !byId("token-hint").hidden && last.server.load.pool_count > 0;
  setText(byId("empty-title"), hasOthers ? "No pools of your token yet" : "No pools yet");
  setText(byId("address"), addressOf(last));
  byId("bench").hidden = last.pools.length === 0;
  tellIfClosed();
  const wanted = new URLSearchParams(location.search).get("pool");
  const pool = chosenPool(wanted, pools);
  byId("pool").hidden = !pool;
  byId("missing").hidden = Boolean(pool) || wanted === null;
  setText(byId("missing-name"), wanted ?? "");
  if ((pool?.name ?? null) !== open) {
    openPool(pool);
  }
  table.draw(connection, pools, last.time_s, open);
  pause.follow(connection, pool?.kind === "pool" ? pool : null);
  if (pool) {
    drawPool(pool);
    plots.add(last.pools, last.time_s);
    episodes.follow(pool, last.pools);
  }
}

function named(text) {
  return last.pools.find(({ name }) => name === text);
}

// Reports that the shown pool is gone, also if another one has its name.
function tellIfClosed() {
  const now = shown && named(shown.name);
  if (shown && now?.create_time_s !== shown.create_time_s) {
    notify(`${shown.name} was closed, and its history is gone.${now ? " This is another pool of the same name." : ""}`, "warn");
    shown = null;
    open = null;
  }
}

// The pool in the URL and no other; without one there the open pool, else one that is being stepped.
function chosenPool(wanted, pools) {
  return wanted === null ? named(open) ?? pools.find((pool) => stateOf(pool, last.time_s).rank === 0) ?? pools[0] : named(wanted);
}

// Shows that states and rates are not known.
function drawUnknown() {
  if (!last) {
    return;
  }
  const unknown = (pool) =>
    ({ ...pool, isUnknown: true, steps_per_second: null, request_p50_ms: null, request_p99_ms: null });
  drawServer({ ...last.server.load, steps_per_second: null });
  table.draw(null, visiblePools().map(unknown), last.time_s, shown?.name ?? null);
  const pool = shown && named(shown.name);
  if (pool) {
    drawPool(unknown(pool));
  }
  nodes.lose();
  plots.lose();
}

// Pools of learners, and those created by pages if the box is checked.
function visiblePools() {
  const learners = last.pools.filter(({ kind }) => kind === "pool");
  return byId("visitors").checked ? last.pools : learners;
}

function drawServer(load) {
  const list = byId("server");
  list.hidden = false;
  setTiles(list, [
    ["Steps / s", rate(load.steps_per_second)], ["Pools", count(load.pool_count)],
    ["Environments", count(load.env_count)],
    ["Workers", count(load.worker_count), "Threads that step environments"], ["Steps so far", rate(load.step_count)],
  ]);
}

// The address for programs: the browser's host name if the server listens on all addresses.
function addressOf({ nodes }) {
  const address = nodes.find(({ name }) => name === self)?.address ?? "";
  return address.replace(/^(0\.0\.0\.0|\[::\]):/, `${location.hostname}:`);
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
  shown = pool ? { name: pool.name, create_time_s: pool.create_time_s } : shown;
  document.title = `${open ?? "Live"} – Procgen Server`;
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
  if (/^\d+$/.test(wanted) && Number(wanted) < pool.env_count) {
    enlarged.show(connection, catalog, pool, Number(wanted));
  } else {
    notify(`${pool.name} has no environment “${wanted}”: environments are 0 to ${pool.env_count - 1}.`, "bad");
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
  setText(byId("pool-name"), pool.name);
  const { text, kind } = stateOf(pool, last.time_s);
  setText(byId("pool-state"), text);
  byId("pool-state").className = `badge ${kind}`;
  const chosen = tellOptions(pool.options, catalog);
  const owner = pool.owner ? [`owner ${pool.owner}`] : [];
  setText(byId("pool-about"), [pool.games.join(", "), pool.mode, ...owner, ...chosen].join(" · "));
  setTiles(byId("pool-figures"), [
    ["Steps / s", rate(pool.steps_per_second)], ["Mean return", reward(pool.mean_return), "Score of the last 100 episodes"],
    ["Mean length", count(pool.mean_length), "Steps of the last 100 episodes"], ["Episodes", count(pool.episode_count)],
    ["Environments", count(pool.env_count)], ["Request p50", milliseconds(pool.request_p50_ms), "Median latency of the last 512 requests"],
    ["Request p99", milliseconds(pool.request_p99_ms), "99th percentile latency of the last 512 requests"], ["Steps so far", rate(pool.step_count)],
  ]);
}

byId("visitors").addEventListener("change", show);
addEventListener("popstate", () => {
  open = null;
  show();
});
openPage(ready, lost, drawUnknown).on("pools", receive);
