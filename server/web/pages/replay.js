// The replay page: opens a trace, shows any row of it, and compares it with the recording.

import { byId, setText, setTiles } from "./elements.js";
import { count, NONE, plural, reward } from "./figures.js";
import { tellOptions } from "./level_choice.js";
import { attempt, notify, openPage } from "./page.js";
import { drawPart, partOf } from "./pictures.js";
import { takesKeys } from "./play_keys.js";
import { drawTimeline } from "./replay_timeline.js";
import { keepTrace, keptTrace, saveTrace } from "./traces.js";

const STEPS_PER_SECOND = 15;

let connection = null;
let catalog = null;
let trace = null;     // { bytes, name }
let replay = null;    // the answer of replay.open
let row = 0;          // the requested row
let shownRow = -1;    // the shown row
let isRunning = false;
let isBusy = false;

const slider = byId("row");
let actions = new Map();  // number -> name

function ready(hello, opened) {
  connection = opened;
  catalog = hello.catalog;
  actions = new Map(catalog.actions.map(({ number, name }) => [number, name]));
  trace ??= keptTrace();
  if (trace) {
    open();
  }
}

function lost() {
  connection = null;
  run(false);
}

async function open() {
  if (replay) {
    connection.call("replay.close", { replay: replay.replay }).catch(() => {});
    replay = null;
  }
  const opened = await attempt(() => connection.call("replay.open", {}, trace.bytes));
  if (!opened) {
    return;
  }
  replay = opened;
  byId("replay").hidden = false;
  setText(byId("name"), trace.name);
  setText(byId("level"), describe(replay.header));
  judge(replay.difference);
  slider.max = replay.rows - 1;
  row = Math.min(row, replay.rows - 1);
  shownRow = -1;
  drawTimeline(byId("rewards"), replay);
  await seek(row);
}

function describe({ games, mode, options, env_count: environments, environment }) {
  const chosen = tellOptions(options, catalog);
  const place = environments > 1 ? [`environment ${environment} of ${environments}`] : [];
  return [games.join(", "), mode, ...place, plural(replay.rows - 1, "step"), ...chosen].join(" · ");
}

// Shows whether the replay equals the recording.
function judge(difference) {
  const verdict = byId("verdict");
  verdict.className = `badge ${difference ? "bad" : "on"}`;
  setText(verdict, difference
    ? `Differs at step ${difference.row}: ${difference.field} is ${difference.got}, was ${difference.expected}`
    : "Identical to the recording");
}

// Shows a row. During a request, only the row requested last waits.
async function seek(wanted) {
  row = Math.max(0, Math.min(wanted, replay.rows - 1));
  slider.value = row;
  if (isBusy) {
    return;
  }
  isBusy = true;
  while (replay && connection && shownRow !== row) {
    const asked = row;
    const view = await attempt(() => connection.call("replay.seek", { replay: replay.replay, row: asked }));
    if (!view) {
      break;
    }
    shownRow = asked;
    await show(view);
  }
  isBusy = false;
}

async function show(view) {
  // First, so that figures and images show the same step.
  await Promise.all(["human", "agent"].map((name) => drawPart(byId(name), partOf(view, name))));
  if (!replay) {
    return;  // Closed in the meantime.
  }
  const action = replay.actions[shownRow - 1];
  setTiles(byId("figures"), [
    ["Step", `${count(shownRow)} of ${count(replay.rows - 1)}`], ["Action", actions.get(action) ?? action ?? NONE],
    ["Reward", reward(view.reward)], ["Score", reward(view.total_reward)],
    ["Level seed", String(view.level_seed)], ["Episode", episodeOf(view)],
    ["Fingerprint", view.fingerprint ?? replay.fingerprint ?? NONE],
  ]);
  const where = `step ${shownRow}, score ${reward(view.total_reward)}`;
  slider.setAttribute("aria-valuetext", where);
  byId("human").setAttribute("aria-label", `${where}, as people see it`);
  byId("agent").setAttribute("aria-label", `${where}, as the agent sees it`);
  drawTimeline(byId("rewards"), replay, shownRow);
}

function episodeOf(view) {
  if (!view.first || shownRow === 0) {
    return "running";
  }
  return view.prev_level_complete ? "level complete" : "over";
}

function run(value) {
  isRunning = value;
  byId("run").firstChild.data = isRunning ? "Pause " : "Play ";
}

function go(wanted) {
  run(false);
  if (replay) {
    seek(wanted);
  }
}

function toggle() {
  if (!isRunning && replay && row === replay.rows - 1) {
    seek(0);
  }
  run(!isRunning && replay !== null);
}

async function take(file) {
  if (!file) {
    return;
  }
  run(false);
  trace = { bytes: new Uint8Array(await file.arrayBuffer()), name: file.name };
  row = 0;
  if (!keepTrace(trace.bytes, trace.name)) {
    notify("The trace is too large to keep: it is lost when the page is reloaded.", "warn");
  }
  if (connection) {
    open();
  }
}

byId("file").addEventListener("change", ({ target }) => take(target.files[0]).then(() => { target.value = ""; }));
const place = byId("open");
document.addEventListener("dragover", (event) => {
  event.preventDefault();
  place.classList.add("over");
});
document.addEventListener("dragleave", () => place.classList.remove("over"));
document.addEventListener("drop", (event) => {
  event.preventDefault();
  place.classList.remove("over");
  take(event.dataTransfer.files[0]);
});

const ACTS = {
  first: () => go(0), back: () => go(row - 1), run: toggle, forward: () => go(row + 1), last: () => go(replay.rows - 1),
  save: () => saveTrace(trace.bytes, trace.name),
};
for (const [name, act] of Object.entries(ACTS)) {
  byId(name).addEventListener("click", act);
}
const SHORTCUTS = { p: "run", ".": "forward", ",": "back" };
document.addEventListener("keydown", (event) => {
  const name = SHORTCUTS[event.key.toLowerCase()];
  const isPlain = !event.ctrlKey && !event.metaKey && !event.altKey;
  if (name && replay && isPlain && (event.target === slider || !takesKeys(event.target))) {
    event.preventDefault();
    ACTS[name]();
  }
});
slider.addEventListener("input", () => go(slider.valueAsNumber));
byId("rewards").addEventListener("pointerdown", ({ offsetX, target }) =>
  replay && go(Math.round(offsetX / target.clientWidth * (replay.rows - 1))));
const redraw = () => replay && drawTimeline(byId("rewards"), replay, shownRow);
document.addEventListener("theme", redraw);
addEventListener("resize", redraw);
setInterval(() => {
  if (isRunning && !isBusy) {
    if (row + 1 < replay.rows) {
      seek(row + 1);
    } else {
      run(false);
    }
  }
}, 1000 / STEPS_PER_SECOND);

openPage(ready, lost);
