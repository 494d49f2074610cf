// A play: a pool of one environment that the player steps, and the recording of its steps.

import { Environment } from "../run/environment.js";
import { Recording } from "../run/recording.js";
import { optionsOf } from "../run/options.js";
import { levelSpec } from "../run/spec.js";

export class PlayRun {
  #environment;
  #recording;
  #start = null;     // what a restart returns to: { rows, state, images }
  #anchor = null;    // the start of the current episode: { rows, state }
  #images = null;    // of the current state
  #finalImages = null;
  #sent = [];        // steps without a view: { action, sizePx, round, row, images, resolve, reject }
  #round = 0;        // number of restarts
  #isSettling = false;
  #isEnding = false;  // the newest step has ended its episode, and the next one begins

  // Starts a level: { game, mode, level, options }. `isOnly`: the mode has no other. Rejects with a UserError.
  static async start(connection, level, isOnly, sizePx) {
    const environment = await Environment.start(connection, "play", levelSpec(level, isOnly));
    const { mode, options } = optionsOf(environment.spec.options);
    const [row, images, state] = await Promise.all([environment.observe(), environment.look(sizePx), environment.save()]);
    return new PlayRun(environment, new Recording({ games: environment.spec.games, mode, options }, row), state, images);
  }

  // Continues a replay at its last row, and takes over its environment.
  static async continue({ environment, recording }, sizePx) {
    const [images, state] = await Promise.all([environment.look(sizePx), environment.save()]);
    return new PlayRun(environment, recording, state, images);
  }

  constructor(environment, recording, state, images) {
    this.#environment = environment;
    this.#recording = recording;
    this.#images = images;
    this.#start = { rows: recording.rows, state, images };
    this.#anchor = this.#start;
  }

  get recording() {
    return this.#recording;
  }

  // What a page shows of the newest row, with `images` { agent, human } and, at the end of an episode, the `finalImages` of it.
  get view() {
    return { ...this.#recording.viewOf(this.#recording.rows - 1), images: this.#images, finalImages: this.#finalImages };
  }

  close() {
    this.#environment.close();
  }

  // Takes a step. Resolves to its view, or to null if a step that was sent before has ended the episode: then it is undone.
  async step(action, sizePx) {
    if (this.#isEnding) {
      return null;
    }
    const row = this.#environment.step(action);
    const images = this.#environment.look(sizePx);
    return new Promise((resolve, reject) => {
      this.#sent.push({ action, sizePx, round: this.#round, row, images, resolve, reject });
      this.#settle();
    });
  }

  // Returns to the start of the level, or to the row at which a replay was continued. Resolves to the view. Steps without a view are void.
  async restart() {
    this.#round += 1;
    this.#isEnding = false;
    this.#environment.restore(this.#start.state);
    this.#recording.truncate(this.#start.rows);
    this.#anchor = this.#start;
    this.#images = this.#start.images;
    this.#finalImages = null;
    return this.view;
  }

  // Records the answers to steps in their order.
  async #settle() {
    if (this.#isSettling) {
      return;
    }
    this.#isSettling = true;
    while (this.#sent.length > 0) {
      const step = this.#sent.shift();
      try {
        step.resolve(await this.#record(step));
      } catch (error) {
        step.reject(error);
      }
    }
    this.#isSettling = false;
  }

  // Resolves to the view of a step, or to null if a restart has made it void.
  async #record({ action, sizePx, round, row: answer, images }) {
    const isVoid = () => round !== this.#round;
    const row = await answer;
    if (!isVoid()) {
      this.#isEnding = row.hasEnded;
    }
    const shown = await images;
    if (isVoid()) {
      return null;
    }
    if (!row.hasEnded) {
      this.#recording.add(action, row, null);
      this.#images = shown;
      this.#finalImages = null;
      return this.view;
    }
    const late = this.#sent.splice(0);
    late.forEach(({ resolve }) => resolve(null));
    if (late.length > 0) {
      await Promise.all(late.flatMap((step) => [step.row, step.images]));
      if (isVoid()) {
        return null;
      }
      this.#repeat(action);
    }
    const [next, start, state] = await Promise.all([this.#environment.step(0), this.#environment.look(sizePx), this.#environment.save()]);
    if (isVoid()) {
      return null;
    }
    this.#recording.add(action, row, next);
    this.#images = start;
    this.#finalImages = shown;
    this.#anchor = { rows: this.#recording.rows, state };
    this.#isEnding = false;
    return this.view;
  }

  // Plays the current episode again, up to its last action: steps that were sent ahead have begun the next one.
  #repeat(lastAction) {
    this.#environment.restore(this.#anchor.state);
    for (const action of [...this.#recording.actions.slice(this.#anchor.rows - 1), lastAction]) {
      this.#environment.step(action);
    }
  }
}
