// The replay page: opens a trace, shows any frame of it, and compares it with the recording.

import { byId, setText } from "./elements/elements.js";
import { clearNotices, notify } from "./elements/notices.js";
import { copy } from "./export/clipboard.js";
import { replayProgram } from "./export/python_code.js";
import { followLink, otherPlaceIn, placeAddress, showWrongLink, subjectOfTrace } from "./links/replay_link.js";
import { keepTrace, saveTrace } from "./links/traces.js";
import { attempt, openPage } from "./page.js";
import { isControl, takesKeys } from "./play/keys.js";
import { Comparison } from "./replay/compare.js";
import { ExportDialog } from "./replay/export.js";
import { Frames } from "./replay/frames.js";
import { LevelMap } from "./replay/map.js";
import { Player } from "./replay/player.js";
import { ReplayRun } from "./replay/replay_run.js";
import { Rows } from "./replay/rows.js";
import { Tracks } from "./replay/tracks.js";
import { describe, drawFrame, frameText, judge } from "./replay/view.js";
import { writeTrace } from "./run/trace_file.js";

const LINK_DELAY_MS = 250;  // browsers limit how often the URL changes

let connection = null;
let hello = null;     // see page.js
let subject = null;   // see links/replay_link.js
let replay = null;    // a ReplayRun
let frames = null;    // of the replay
let linkTimer = null;

const slider = byId("row");
const player = new Player({
  onWant: (index) => { slider.value = index; },
  onShow: show,
  onRun: (isRunning) => {
    byId("run").firstChild.data = isRunning ? "Pause " : "Play ";
    tellPlace();
  },
});
const exportDialog = new ExportDialog(() => ({
  replay, frames, index: player.wanted, speed: player.speed, name: subject.name, texts: (frame) => frameText(replay, frame, actionNames),
  values: tracks.texts,
}));
const comparison = new Comparison(() => ({ connection, replay, place: subject?.place, actionNames }), async (row) => {
  if (row !== null) {
    await player.go(frames.ofRow(row));
  }
  comparison.show(frames.at(player.wanted));
  tellPlace();
});
const map = new LevelMap(() => ({ replay }));
const tracks = new Tracks((frame) => player.go(Math.round(frame)));
let actionNames = new Map();  // by number

async function ready(greeting, opened) {
  connection = opened;
  hello = greeting;
  actionNames = new Map(hello.catalog.actions.map(({ number, name }) => [number, name]));
  if (subject) {
    open();
  } else {
    await follow();
  }
}

// Opens what the URL selects.
async function follow() {
  const query = new URLSearchParams(location.search);
  try {
    const found = await attempt(() => followLink(connection, query));
    if (found?.subject) {
      subject = found.subject;
      await open(found.step);
      const other = otherPlaceIn(query);
      if (other && replay) {
        comparison.openPlace(other);
      }
    }
  } catch (error) {
    showWrongLink(error.message, query);
  }
}

function lost() {
  connection = null;
  player.close();
  map.close();
  comparison.lose();
}

// Opens the subject, at a step or, without one, at the frame shown before.
async function open(step = null) {
  player.close();
  map.close();
  replay?.close();
  replay = null;
  const opened = await attempt(() => ReplayRun.open(connection, subject.source));
  if (!opened) {
    byId("replay").hidden = connection !== null;
    return;
  }
  replay = opened;
  subject.name ??= replay.recording.fileName;
  frames = new Frames(replay.recording);
  if (subject.place) {
    keepTrace({ bytes: traceBytes(), name: subject.name, place: subject.place });
  }
  byId("wrong").hidden = true;
  byId("replay").hidden = false;
  setText(byId("name"), subject.name);
  setText(byId("level"), describe(replay, hello.catalog));
  judge(replay.difference);
  tracks.open(replay, frames, hello.catalog.actions);
  slider.max = frames.last;
  comparison.reopen();
  await player.open(new Rows(replay), frames, step === null ? player.wanted : frameOf(step));
}

// The trace of the subject: the file that was opened, or what was replayed.
function traceBytes() {
  return subject.bytes ?? writeTrace(replay.recording);
}

function frameOf(step) {
  if (step >= replay.rows) {
    notify(`This link is to step ${step}, the replay has ${replay.rows - 1} steps.`, "warn");
  }
  return frames.ofRow(Math.min(step, replay.rows - 1));
}

async function show(index, view, rows) {
  const shown = replay;
  const other = comparison.show(frames.at(index), rows);
  map.show(frames.at(index));
  if (await drawFrame(replay, view, frames.at(index), actionNames, () => replay !== null && replay === shown)) {
    tracks.show(index);
    tellPlace();
  }
  await other;
}

// Shows the place in the URL, except while the replay runs.
function tellPlace() {
  clearTimeout(linkTimer);
  if (replay && !player.isRunning) {
    linkTimer = setTimeout(() => history.replaceState(null, "", address()), LINK_DELAY_MS);
  }
}

function address(path = "/replay") {
  return placeAddress(path, subject.place, frames.at(player.wanted).row, path === "/replay" ? comparison.place : null);
}

function program() {
  const { row, isStart } = frames.at(player.wanted);
  const isEnd = replay.recording.isEnd(row) && !isStart;
  return replayProgram({ source: replay.source, name: subject.name, row, isEnd }, hello);
}

async function take(file) {
  if (!file) {
    return;
  }
  player.run(false);
  clearNotices();
  const bytes = new Uint8Array(await file.arrayBuffer());
  const opened = await attempt(() => ({ ...subjectOfTrace({ bytes, name: file.name }), bytes }));
  if (!opened) {
    return;
  }
  subject = opened;
  if (!keepTrace({ bytes, name: file.name, place: null })) {
    notify("The trace is too large to keep: it is lost when the page is reloaded.", "warn");
  }
  if (connection) {
    open(0);
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
  first: () => player.go(0), back: () => player.go(player.wanted - 1), run: () => player.toggle(),
  forward: () => player.go(player.wanted + 1), last: () => player.go(frames.last),
  save: () => saveTrace(traceBytes(), subject.name), "open-export": () => exportDialog.show(),
  "copy-python": () => copy(program(), "a program that replays up to this step"),
  "play-here": () => location.assign(address("/play")),
};
for (const [name, act] of Object.entries(ACTS)) {
  byId(name).addEventListener("click", () => replay && act());
}
byId("speed").addEventListener("change", ({ target }) => { player.speed = Number(target.value); });

const SHORTCUTS = {
  p: "run", " ": "run", ".": "forward", ",": "back", ArrowRight: "forward", ArrowLeft: "back", Home: "first", End: "last",
};
// The slider handles arrows, Home and End itself; buttons and links are pressed with the space bar.
const OWN_KEYS = [[slider, ["ArrowRight", "ArrowLeft", "Home", "End"]]];

document.addEventListener("keydown", (event) => {
  const { target, key } = event;
  const name = SHORTCUTS[key.length === 1 ? key.toLowerCase() : key];
  const isPlain = !event.ctrlKey && !event.metaKey && !event.altKey && !event.shiftKey;
  const isOwn = OWN_KEYS.some(([element, keys]) => element === target && keys.includes(key))
    || (key === " " && isControl(target));
  if (name && replay && isPlain && !isOwn && (target === slider || !takesKeys(target))) {
    event.preventDefault();
    ACTS[name]();
  }
});
slider.addEventListener("input", () => player.go(slider.valueAsNumber));

openPage(ready, lost);
