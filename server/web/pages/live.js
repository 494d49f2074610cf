// The live view: follows the server's pools and opens the one in the URL, or else the first.

import { byId, element, setText, setTiles } from "./elements.js";
import { count, milliseconds, plural, rate, reward } from "./figures.js";
import { tellOptions } from "./level_choice.js";
import { EnlargedView } from "./live_enlarged.js";
import { Mosaic } from "./live_mosaic.js";
import { NodeTable } from "./live_nodes.js";
import { Plots } from "./live_plots.js";
import { attempt, notify, openPage } from "./page.js";

let connection = null;
let catalog = null;
let self = null;   // the server's node name
let open = null;   // the name of the open pool
let last = null;   // the last event "pools"

const enlarged = new EnlargedView();
const mosaic = new Mosaic((pool, environment) => enlarged.show(connection, pool, environment));
const nodes = new NodeTable(byId("node-rows"));
const plots = new Plots(byId("plots"));

async function ready(hello, opened) {
  connection = opened;
  open = null;
  catalog = hello.catalog;
  self = hello.node;
  byId("nodes").hidden = !(hello.cluster || hello.is_fleet);
  await attempt(() => connection.call("pools.follow"));
}

function lost() {
  open = null;
  mosaic.stop();
  enlarged.close();
}

function show(event) {
  last = event;
  drawServer(event);
  nodes.draw(event.nodes, event.time_s);
  const pools = visiblePools();
  byId("empty").hidden = pools.length > 0;
  setText(byId("address"), addressOf(event));
  byId("bench").hidden = event.pools.length === 0;
  drawPools(pools);
  const pool = chosenPool(pools);
  byId("pool").hidden = !pool;
  if (pool?.name !== open) {
    openPool(pool);
  }
  if (pool) {
    drawPool(pool);
    plots.add(pool, event.time_s);
  }
}

// The pool in the URL, else the open one, else one that is being stepped.
function chosenPool(pools) {
  const wanted = new URLSearchParams(location.search).get("pool");
  const named = (text) => last.pools.find(({ name }) => name === text);
  if (open && !named(open)) {
    notify(`${open} was closed.`);
  }
  return named(wanted) ?? named(open) ?? pools.find(({ attached }) => attached) ?? pools[0];
}

// Pools of learners, and those created by pages if the box is checked.
function visiblePools() {
  const learners = last.pools.filter(({ kind }) => kind === "pool");
  return byId("visitors").checked ? last.pools : learners;
}

function drawServer({ server: { load } }) {
  const list = byId("server");
  list.hidden = false;
  setTiles(list, [
    ["Steps / s", rate(load.steps_per_second)], ["Pools", count(load.pool_count)],
    ["Environments", count(load.env_count)], ["Learners", count(load.stream_count), "Programs that step a pool"],
    ["Workers", count(load.worker_count), "Threads that step environments"], ["Steps so far", rate(load.step_count)],
  ]);
}

// The address for programs: the browser's host name if the server listens on all addresses.
function addressOf({ nodes }) {
  const address = nodes.find(({ name }) => name === self)?.address ?? "";
  return address.replace(/^(0\.0\.0\.0|\[::\]):/, `${location.hostname}:`);
}

function drawPools(pools) {
  const list = byId("pools");
  const names = pools.map(({ name }) => name).join("\n");
  if (list.dataset.names !== names) {
    list.dataset.names = names;
    list.replaceChildren(...pools.map(({ name }) => element("li", {},
      element("a", { href: `/?pool=${encodeURIComponent(name)}`, onclick: follow },
        element("b", {}, name), element("span", { class: "quiet" }), element("span", { class: "number" })))));
  }
  pools.forEach((pool, index) => {
    const link = list.children[index].firstChild;
    const [, about, figures] = link.children;
    const owner = pool.owner ? [pool.owner] : [];
    setText(about, [gamesOf(pool), pool.mode, plural(pool.env_count, "environment"), ...owner].join(" · "));
    const mean = pool.mean_return === null ? "" : ` · return ${reward(pool.mean_return)}`;
    setText(figures, pool.attached ? `${rate(pool.steps_per_second)} steps/s${mean}` : `idle${mean}`);
    if (pool.name === open) {
      link.setAttribute("aria-current", "true");
    } else {
      link.removeAttribute("aria-current");
    }
  });
}

function gamesOf({ games }) {
  return games.length > 3 ? `${games.length} games` : games.join(", ");
}

// Opens a pool in this page, unless the link opens in another tab.
function follow(event) {
  if (event.ctrlKey || event.metaKey || event.shiftKey) {
    return;
  }
  event.preventDefault();
  history.pushState(null, "", event.currentTarget.href);
  show(last);
  byId("pool").focus({ preventScroll: true });
}

async function openPool(pool) {
  open = pool?.name ?? null;
  drawPools(visiblePools());
  document.title = `${open ?? "Live"} – Procgen Server`;
  enlarged.close();
  mosaic.open(connection, pool);
  plots.clear();
  if (pool) {
    const history = await attempt(() => connection.call("pool.history", { pool: pool.name }));
    if (history && open === pool.name) {
      plots.begin(history);
    }
  }
}

function drawPool(pool) {
  setText(byId("pool-name"), pool.name);
  const state = byId("pool-state");
  setText(state, pool.attached ? "A learner is attached" : "No learner attached");
  state.classList.toggle("on", pool.attached);
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

byId("visitors").addEventListener("change", () => show(last));
addEventListener("popstate", () => {
  open = null;
  if (last) {
    show(last);
  }
});
openPage(ready, lost).on("pools", show);
