// The play page: starts a level, steps it with the held keys and shows it.

import { byId, setText } from "./elements/elements.js";
import { notify } from "./elements/notices.js";
import { addressOf, drawGames, drawOptions, optionsOf, readAddress } from "./links/level_choice.js";
import { showLinkProblems } from "./links/level_link.js";
import { attempt, openPage } from "./page.js";
import { followBranch, openBranch } from "./play/branch.js";
import { actionOf, isControl, Keys, takesKeys } from "./play/keys.js";
import { describeEnd, factsOf, hasNext, isOnlyLevel, isTouched, levelOf, tellLevel } from "./play/level.js";
import { PlayRun } from "./play/play_run.js";
import { StepPace } from "./play/step_pace.js";
import { listenToTraceButtons } from "./play/traces.js";
import { drawView } from "./play/view.js";

const STEPS_PER_SECOND = 15;
// Keys pressed this soon after the end of an episode were meant for it.
const END_SHOWN_MS = 500;

const form = byId("choice");
const stage = byId("stage");
const keys = new Keys();
let hello = null;     // see page.js
let catalog = null;   // the server's
let connection = null;
let play = null;      // a PlayRun
let view = null;      // the last one; null: no play
let level = null;     // the current level: { game, mode, level, options }
let branch = null;    // the replay that is continued: { subject, step }; null: none
let isPaused = true;
let isWaiting = false;  // paused at a level's start, until a key of the game is pressed
let endTime = null;   // when the shown episode ended, by performance.now(); null: it has not
let turn = 0;         // steps since a key was pressed
let asked = 0;        // number of requested views that are not shown yet
let pace = new StepPace();

async function ready(greeting, opened) {
  hello = greeting;
  connection = opened;
  view = null;
  pace = new StepPace();
  if (!catalog) {
    catalog = hello.catalog;
    drawOptions(byId("options"), catalog);
    drawGames(form, catalog);
    await readLink(new URLSearchParams(location.search));
    describe();
  }
  if (!stage.hidden) {
    begin();
  }
}

// Reads the URL: of a level, or of a step of a replay that is to be continued.
async function readLink(query) {
  if (!query.has("step")) {
    readAddress(form, query);
    stage.hidden = showLinkProblems(catalog);
    return;
  }
  stage.hidden = true;
  branch = await followBranch(connection, query);
  stage.hidden = !branch;
}

function lost() {
  view = null;
  play = null;
  endTime = null;
  pause(true);
  say("The connection was lost. The level restarts after reconnecting.");
}

// Starts the level in the form, or continues the replay of the URL.
async function begin() {
  stage.hidden = false;
  byId("wrong").hidden = true;
  view = null;
  play?.close();
  play = null;
  say("The level is on its way.");
  if (!await (branch ? continueReplay() : startLevel())) {
    view = null;
  }
  if (endTime === null) {
    waitForKey();
  }
  stage.focus({ preventScroll: true });
}

function startLevel() {
  level = {
    game: form.elements.game.value, mode: form.elements.mode.value, level: form.elements.level.valueAsNumber,
    options: optionsOf(form, catalog),
  };
  tellLevel(level, catalog);
  return ask(() => take(PlayRun.start(connection, level, isOnlyLevel(catalog, level), pace.sizePx)));
}

function continueReplay() {
  return ask(async () => {
    const first = await take(openBranch(connection, branch, pace.sizePx));
    tellBranch(first);
    return first;
  });
}

// Plays what was started, in place of the play before. Resolves to its view.
async function take(started) {
  const next = await started;
  play?.close();  // of a level that was chosen meanwhile
  play = next;
  return play.view;
}

// Shows the level at which a replay is continued.
function tellBranch(first) {
  level = levelOf(branch.subject.source, first, catalog);
  readAddress(form, new URL(addressOf("/play", level), location.href).searchParams);
  tellLevel(level, catalog, `${branch.subject.name} from step ${branch.step}`);
}

// A level starts at the first key press, so that the player is ready.
function waitForKey() {
  if (view) {
    pause(true);
    keys.take();
    isWaiting = true;
    drawMain();
    say(isTouched() ? "Touch an arrow below to begin." : `${factsOf(catalog, level.game).description} Press an arrow key to begin.`);
  }
}

// Whether the main button starts the next level: after success, if there is one.
function leadsOn() {
  return view.prevLevelComplete && hasNext(catalog, level);
}

// The label of the main button.
function drawMain() {
  const [text, key] = endTime !== null ? [leadsOn() ? "Next level" : "Play again", "↵"]
    : [isWaiting ? "Begin" : isPaused ? "Resume" : "Pause", "P"];
  byId("pause").firstChild.data = `${text} `;
  setText(byId("pause").querySelector("kbd"), key);
}

// Shows the view that `request()` resolves to, if any. Views come in the order of the requests. Returns whether there was one.
async function ask(request) {
  asked += 1;
  const next = await attempt(request);
  if (next) {
    await show(next);
  }
  asked -= 1;
  return next !== null;
}

async function show(next) {
  view = next;
  say("");
  endTime = null;
  if (view.first && view.step > 0) {
    endTime = performance.now();
    pause(true);
    say(describeEnd(view, leadsOn()));
  }
  [...Object.keys(ACTS), "save", "replay", "copy-python"].forEach((id) => { byId(id).disabled = false; });
  await draw(next, endTime !== null);
}

function draw(drawn, isEnd) {
  return drawView(level, drawn, isEnd, () => view === drawn);
}

// Shows the start of the next episode in place of the end of the last one.
function leaveEnd() {
  endTime = null;
  say("");
  pause(true);
  return draw(view, false);
}

// What the main button does after an episode.
function goOn() {
  if (leadsOn()) {
    act("next");
  } else {
    leaveEnd();
    waitForKey();
  }
}

function say(text) {
  setText(byId("message"), text);
}

function step() {
  turn += 1;
  const action = actionOf(catalog.actions, keys.take(), turn - 1);
  return ask(() => play.step(action, pace.sizePx));
}

function pause(value) {
  isPaused = value;
  isWaiting = false;
  drawMain();
}

// The actions of buttons.
const ACTS = {
  pause: () => {
    if (endTime !== null) {
      goOn();
      return;
    }
    keys.take();
    pause(!isPaused);
    say("");
  },
  step: () => {
    if (endTime !== null) {
      leaveEnd();
      return;
    }
    pause(true);
    step();
  },
  restart: () => {
    pause(true);
    ask(() => play.restart()).then(waitForKey);
  },
  next: () => {
    pause(true);
    goToNext();
  },
};

// Acts as a button; not without a level.
function act(name) {
  if (view) {
    ACTS[name]();
  }
}


// Starts the level of the next seed, if there is one.
function goToNext() {
  if (!hasNext(catalog, level)) {
    notify(`Level ${level.level} is the ${isOnlyLevel(catalog, level) ? "only one of this mode" : "last one"}.`, "bad");
    return;
  }
  branch = null;
  form.elements.level.value = level.level + 1;
  begin();
}

// Describes the game in the form.
function describe() {
  setText(byId("about"), factsOf(catalog, form.elements.game.value).description);
}

form.addEventListener("submit", (event) => {
  event.preventDefault();
  if (connection) {
    branch = null;
    begin();
  }
});
form.elements.game.addEventListener("change", () => catalog && describe());
Object.keys(ACTS).forEach((name) => byId(name).addEventListener("click", () => act(name)));
listenToTraceButtons(() => ({ play, level, hello }), () => isWaiting || pause(true));

// The space bar is everybody's first key; buttons and links are pressed with it.
const SHORTCUTS = { p: "pause", " ": "pause", ".": "step", r: "restart", n: "next" };
document.addEventListener("keydown", (event) => {
  const name = SHORTCUTS[event.key.toLowerCase()];
  const isPressed = event.key === " " && isControl(event.target);
  if (name && !event.ctrlKey && !event.metaKey && !event.altKey && !takesKeys(event.target) && !isPressed) {
    event.preventDefault();
    act(name);
  }
  if (event.key === "Enter" && endTime !== null && !isControl(event.target) && !takesKeys(event.target)) {
    goOn();
  }
});
keys.listen(document.querySelector(".pad"), (isRepeat) => {
  if (isRepeat && !isWaiting) {
    return;  // A key that is held since before the level was there begins it, too.
  }
  turn = 0;
  if (endTime !== null && performance.now() - endTime > END_SHOWN_MS) {
    leaveEnd();
    pause(false);
  } else if (isWaiting) {
    pause(false);
  }
});
setInterval(() => {
  if (view && !isPaused && !document.hidden && pace.mayStep(asked, view.images.human.width)) {
    step();
  }
}, 1000 / STEPS_PER_SECOND);

openPage(ready, lost);
