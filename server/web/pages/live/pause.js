// Pauses the learner of a pool and lets single requests pass.

import { element, setText } from "../elements/elements.js";
import { notify } from "../elements/notices.js";
import { attempt } from "../page.js";

// A forgotten page does not pause a learner forever.
const FORGOTTEN_MS = 10 * 60_000;

export class LearnerPause {
  #connection = null;
  #pool = null;       // of the newest event
  #call = null;       // PausePool, while this page pauses the pool
  #timer = 0;
  #groups;

  // `places`: elements that get the buttons.
  constructor(...places) {
    this.#groups = places.map((place) => {
      const group = {
        toggle: element("button", { type: "button", onclick: () => this.#toggle() }),
        step: element("button", { type: "button", title: "Lets the next request of the learner pass", onclick: () => this.#step() }, "Next step"),
        state: element("span", { class: "quiet small", role: "status" }),
      };
      place.append(group.toggle, group.step, group.state);
      return group;
    });
    this.#draw();
  }

  // Shows the newest state of the open pool; null: no pool is open. The pause ends when another pool is opened.
  follow(connection, pool) {
    if (this.#call && pool?.name !== this.#pool.name) {
      this.#release();
    }
    this.#connection = connection;
    this.#pool = pool;
    this.#draw();
  }

  // The connection broke, which ended the pause.
  lose() {
    clearTimeout(this.#timer);
    this.#call = null;
    this.#connection = null;
    this.#draw();
  }

  async #toggle() {
    if (this.#call) {
      this.#release();
    } else {
      await attempt(() => this.#pause());
    }
    this.#draw();
  }

  // Pauses the pool, until the call ends. Resolves when it is paused.
  #pause() {
    return new Promise((resolve, reject) => {
      const call = this.#connection.open("PoolService.PausePool", resolve, (error) => {
        if (this.#call === call) {
          clearTimeout(this.#timer);
          this.#call = null;
          this.#draw();
        }
        reject(error);
      });
      this.#call = call;
      call.send({ name: this.#pool.name });
      this.#delayRelease();
    });
  }

  // Lets a request pass.
  #step() {
    this.#delayRelease();
    this.#call.send({});
  }

  #release() {
    clearTimeout(this.#timer);
    this.#call.cancel();
    this.#call = null;
  }

  #delayRelease() {
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => {
      notify(`The learner of ${this.#pool.name} runs again: it was paused for ten minutes without a step.`, "warn");
      this.#release();
      this.#draw();
    }, FORGOTTEN_MS);
  }

  #draw() {
    const isPaused = this.#call !== null || this.#pool?.paused;
    for (const { toggle, step, state } of this.#groups) {
      setText(toggle, this.#call !== null ? "Resume learner" : "Pause learner");
      toggle.disabled = !this.#connection || !this.#pool;
      step.hidden = this.#call === null;
      setText(state, !isPaused ? "" : this.#call !== null ? "Paused: the learner waits." : "Paused by another page.");
    }
  }
}
