// The newest step of an enlarged environment: the action as keys, the reward, and the episode so far.

import { byId, element, setTiles } from "../elements/elements.js";
import { count, NONE, reward } from "../elements/figures.js";

// How long a reward stays.
const REWARD_SHOWN_MS = 700;
const END_EPISODE = -1;
const ARROWS = ["LEFT", "DOWN", "UP", "RIGHT"];

export class StepView {
  #actions;       // number -> { name, keys }
  #last = null;   // the step shown last
  #reward = 0;    // the newest reward other than 0
  #rewardTime = -Infinity;

  // `catalog`: the server's; `game`: the environment's.
  constructor(catalog, game) {
    this.#actions = new Map(catalog.actions.map((action) => [action.number, action]));
    const special = catalog.games.find(({ name }) => name === game).specialActions;
    const letters = special.flatMap(({ action }) => this.#actions.get(action).keys);
    byId("large-keys").replaceChildren(...[...ARROWS, ...letters].map((key) => element("kbd", {}, key)));
    this.#draw(null);
  }

  // Shows the step of a frame; undefined if none is known.
  show(step) {
    this.#noteReward(step);
    this.#last = step ?? null;
    this.#draw(this.#last);
  }

  // Frames skip steps: the change of the return contains the rewards of all of them.
  #noteReward(step) {
    if (!step || step.action === null) {
      return;
    }
    const isSameEpisode = this.#last && this.#last.length <= step.length;
    const gained = step.length === this.#last?.length ? 0 : step.return - (isSameEpisode ? this.#last.return : 0);
    if (gained !== 0) {
      this.#reward = gained;
      this.#rewardTime = performance.now();
    }
  }

  #draw(step) {
    const action = this.#actions.get(step?.action);
    for (const key of byId("large-keys").children) {
      key.toggleAttribute("data-pressed", action?.keys.includes(key.textContent) ?? false);
    }
    const flashes = performance.now() - this.#rewardTime < REWARD_SHOWN_MS;
    const gained = flashes ? this.#reward : 0;
    setTiles(byId("large-step"), [
      ["Action", nameOf(step, action)],
      ["Reward", step ? `${gained > 0 ? "+" : ""}${reward(gained)}` : NONE, "Of the steps since the frame before"],
      ["Return", reward(step?.return), "Sum of the rewards of this episode"], ["Step", count(step?.length)],
      ["Level seed", step ? String(step.levelSeed) : NONE],
    ]);
    byId("large-step").children[1].lastChild.className = gained > 0 ? "gain" : gained < 0 ? "loss" : "";
  }
}

function nameOf(step, action) {
  if (!step) {
    return NONE;
  }
  return step.action === null ? "start" : step.action === END_EPISODE ? "end episode" : action.name;
}
