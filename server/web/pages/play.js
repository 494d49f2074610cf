// The play page: starts a level, steps it with the held keys and shows it.

import { byId, setText, setTiles } from "./elements.js";
import { count, reward } from "./figures.js";
import { addressOf, drawGames, drawOptions, optionsOf, readAddress } from "./level_choice.js";
import { attempt, notify, openPage } from "./page.js";
import { drawPart, partOf } from "./pictures.js";
import { actionOf, Keys, takesKeys } from "./play_keys.js";
import { replayTrace, saveTrace } from "./traces.js";

const STEPS_PER_SECOND = 15;

const form = byId("choice");
const stage = byId("stage");
const keys = new Keys();
let catalog = null;
let connection = null;
let view = null;      // the last one; null: no play
let level = null;     // the current level: { game, mode, level, options }
let isPaused = true;
let isWaiting = false;  // paused at a level's start, until a key of the game is pressed
let asked = 0;        // number of requested views that are not shown yet

function ready(hello, opened) {
  connection = opened;
  view = null;
  if (!catalog) {
    catalog = hello.catalog;
    drawOptions(byId("options"), catalog);
    drawGames(form, catalog);
    readAddress(form, new URLSearchParams(location.search));
    describe();
  }
  begin();
}

function lost() {
  view = null;
  pause(true);
  say("The connection was lost. The level restarts after reconnecting.");
}

async function begin() {
  level = {
    game: form.elements.game.value, mode: form.elements.mode.value, level: form.elements.level.valueAsNumber,
    options: optionsOf(form, catalog),
  };
  tellLevel();
  if (view) {
    connection.call("play.close", { play: view.play }).catch(() => {});
    view = null;
  }
  const { game, mode, options } = level;
  if (!await ask("play.start", { game, mode, level_seed: level.level, options })) {
    view = null;
  }
  waitForKey();
  stage.focus({ preventScroll: true });
}

// Shows the level in the URL, the title and the page.
function tellLevel() {
  history.replaceState(null, "", addressOf("/play", level));
  document.title = `${level.game}, level ${level.level} – Procgen Server`;
  setText(byId("playing"), `${level.game}, ${level.mode}, level ${level.level}`);
}

// A level starts at the first key press, so that the player is ready.
function waitForKey() {
  if (view) {
    pause(true);
    keys.take();
    isWaiting = true;
    byId("pause").firstChild.data = "Begin ";
    say(`${factsOf(level.game).description} Press an arrow key to begin.`);
  }
}

// Sends a request whose answer is the next view of the play, and shows it. Answers come in the order of the requests.
// Returns whether there was a view.
async function ask(method, fields = {}) {
  asked += 1;
  const next = await attempt(() => connection.call(method, view ? { play: view.play, ...fields } : fields));
  if (next) {
    await show(next);
  }
  asked -= 1;
  return next !== null;
}

async function show(next) {
  view = next;
  const score = reward(view.total_reward);
  say("");
  if (view.first && view.step > 0) {
    pause(true);
    say(`${view.prev_level_complete ? "Level complete" : "Episode over"}: score ${score} in ${count(view.episode_step)} steps. `
      + "Restart to play it again.");
  }
  for (const id of ["pause", "step", "restart", "next", "save", "replay"]) {
    byId(id).disabled = false;
  }
  await Promise.all(["human", "agent"].map((name) => drawPart(byId(name), partOf(next, name))));
  if (view === next) {  // Figures and images must show the same step.
    const where = `${level.game}, level ${view.level_seed}, step ${view.episode_step}, score ${score}`;
    byId("human").setAttribute("aria-label", `${where}, as people see it`);
    byId("agent").setAttribute("aria-label", `${where}, as the agent sees it`);
    setTiles(byId("figures"), [
      ["Score", score], ["Step", count(view.episode_step)], ["Level seed", String(view.level_seed)],
      ["Reward", reward(view.reward)], ["Episodes", count(view.episode_count)],
    ]);
  }
}

function say(text) {
  setText(byId("message"), text);
}

function step() {
  return ask("play.step", { action: actionOf(catalog.actions, keys.take()) });
}

function pause(value) {
  isPaused = value;
  isWaiting = false;
  byId("pause").firstChild.data = isPaused ? "Resume " : "Pause ";
}

// The action of a button; none without a level.
function act(name) {
  if (!view) {
    return;
  }
  switch (name) {
    case "pause":
      keys.take();
      pause(!isPaused);
      say("");
      break;
    case "step":
      pause(true);
      step();
      break;
    case "restart":
      ask("play.restart").then(waitForKey);
      break;
    case "next":
      ask("play.next_level").then((isThere) => isThere && follow());
      break;
  }
}

// Sets the form and the URL to the current level.
function follow() {
  level.level = view.level_seed;
  form.elements.level.value = view.level_seed;
  tellLevel();
  waitForKey();
}

async function withTrace(use) {
  pause(true);
  const trace = await attempt(() => connection.call("play.trace", { play: view.play }));
  if (trace) {
    use(partOf(trace, "trace").content, trace.file_name, trace.fingerprint);
  }
}

function factsOf(game) {
  return catalog.games.find(({ name }) => name === game);
}

// The keys of the chosen game other than moves, with their descriptions.
function describe() {
  const { description, special_actions } = factsOf(form.elements.game.value);
  const keyOf = (action) => catalog.actions[action].name;
  setText(byId("about"), description);
  setText(byId("special_keys"), special_actions.map((special) => `${keyOf(special.action)}: ${special.description}`).join(" "));
}

form.addEventListener("submit", (event) => {
  event.preventDefault();
  if (connection) {
    begin();
  }
});
form.elements.game.addEventListener("change", () => catalog && describe());
for (const name of ["pause", "step", "restart", "next"]) {
  byId(name).addEventListener("click", () => act(name));
}
byId("save").addEventListener("click", () => withTrace((bytes, name, fingerprint) => {
  saveTrace(bytes, name);
  notify(`Saved ${name}, ${fingerprint ? `fingerprint ${fingerprint}` : "episode not finished"}.`);
}));
byId("replay").addEventListener("click", () => withTrace(replayTrace));

const SHORTCUTS = { p: "pause", ".": "step", r: "restart", n: "next" };
document.addEventListener("keydown", (event) => {
  const name = SHORTCUTS[event.key.toLowerCase()];
  if (name && !event.ctrlKey && !event.metaKey && !event.altKey && !takesKeys(event.target)) {
    event.preventDefault();
    act(name);
  }
});
keys.listen(document.querySelector(".pad"), () => {
  if (isWaiting) {
    pause(false);
  }
});
setInterval(() => {
  if (view && !isPaused && asked === 0 && !document.hidden) {
    step();
  }
}, 1000 / STEPS_PER_SECOND);

openPage(ready, lost);
