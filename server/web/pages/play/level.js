// The level of the play page: its facts, and what the page says about it.

import { byId, element, setText } from "../elements/elements.js";
import { count, reward } from "../elements/figures.js";
import { addressOf } from "../links/level_choice.js";
import { LEVEL_MAX } from "../links/level_link.js";
import { baselinesOf } from "./baselines.js";

export function factsOf(catalog, game) {
  return catalog.games.find(({ name }) => name === game);
}

// Whether the mode of a level, { game, mode, level, options }, has no other.
export function isOnlyLevel(catalog, { game, mode }) {
  return factsOf(catalog, game).modes.find(({ name }) => name === mode).levelSeed !== undefined;
}

// Whether a level has a next one.
export function hasNext(catalog, level) {
  return !isOnlyLevel(catalog, level) && level.level < LEVEL_MAX;
}

// The level at the view of a play that continues the replay of this source.
export function levelOf({ games, mode, options, environment }, view, catalog) {
  const chosen = catalog.options.filter(({ name, default: usual }) => (options[name] ?? usual) !== usual);
  return {
    game: games[environment % games.length], mode, level: view.levelSeed,
    options: Object.fromEntries(chosen.map(({ name }) => [name, options[name]])),
  };
}

// Shows a level in the URL, the title and the page. `from`: what a continued replay starts from; its URL stays.
export function tellLevel(level, catalog, from = null) {
  if (!from) {
    history.replaceState(null, "", addressOf("/play", level));
  }
  document.title = `${level.game}, level ${level.level} – Procgen Server`;
  setText(byId("playing"), `${level.game}, ${level.mode}, level ${level.level}`);
  const baselines = baselinesOf(level.game, level.mode).map(([name, value]) => `${name} ${reward(value)}`);
  setText(byId("scores"), baselines.length === 0 ? "" : `Mean scores to compare with: ${baselines.join("; ")}.`);
  setText(byId("from"), from ? `Continues ${from}. Restart returns to it.` : "");
  const effects = effectsOf(catalog, level.game);
  setText(byId("special_keys"), effects.map(([description, keys]) => `${keys.join(", ")}: ${description}`).join(" "));
  byId("letters").replaceChildren(...effects.map(([description, [key]]) =>
    element("button", { type: "button", "data-key": key }, element("b", {}, key), ` ${description.split(/[,.]/)[0]}`)));
}

// What the special actions of a game do, with their keys: [["Fires.", ["D", "W"]], ["Jumps.", ["A"]]].
function effectsOf(catalog, game) {
  const effects = new Map();
  for (const { action, description } of factsOf(catalog, game).specialActions) {
    effects.set(description, [...effects.get(description) ?? [], catalog.actions[action].name]);
  }
  return [...effects];
}

export function isTouched() {
  return matchMedia("(pointer: coarse)").matches;
}

// What is said at the end of an episode. `leadsOn`: the main button starts the next level.
export function describeEnd(view, leadsOn) {
  const result = `${view.prevLevelComplete ? "Level complete" : "Episode over"}: score ${reward(view.totalReward)} in `
    + `${count(view.episodeStep)} steps.`;
  const again = `${isTouched() ? "An arrow" : "An arrow key"} plays ${leadsOn ? "this level" : "it"} again`;
  return `${result} ${again}${leadsOn && !isTouched() ? ", Enter the next one" : ""}.`;
}
