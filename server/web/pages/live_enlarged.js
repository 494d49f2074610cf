// A dialog with an enlarged environment, whose episodes can be saved and replayed.

import { byId, setText } from "./elements.js";
import { Watch } from "./live_watch.js";
import { drawPart, partOf } from "./pictures.js";
import { replayTrace } from "./traces.js";

const SIZE_PX = 512;
const FRAMES_PER_SECOND = 15;

export class EnlargedView {
  #connection = null;
  #pool = null;
  #environment = 0;
  #watch = null;
  #dialog = byId("large");

  constructor() {
    this.#dialog.addEventListener("close", () => this.#stop());
    this.#dialog.addEventListener("keydown", ({ key }) => {
      if (key === "ArrowLeft" || key === "ArrowRight") {
        this.#turn(key === "ArrowLeft" ? -1 : 1);
      }
    });
    byId("close").addEventListener("click", () => this.close());
    byId("previous").addEventListener("click", () => this.#turn(-1));
    byId("following").addEventListener("click", () => this.#turn(1));
    byId("keep-last").addEventListener("click", () => this.#keep("last"));
    byId("keep-current").addEventListener("click", () => this.#keep("current"));
  }

  show(connection, pool, environment) {
    this.#connection = connection;
    this.#pool = pool;
    this.#environment = environment;
    if (!this.#dialog.open) {
      this.#dialog.showModal();
    }
    this.#begin();
  }

  close() {
    this.#dialog.close();
  }

  #turn(by) {
    const { env_count: all } = this.#pool;
    this.#environment = (this.#environment + by + all) % all;
    this.#begin();
  }

  #begin() {
    this.#stop();
    this.#say("");
    setText(byId("large-title"), `${this.#pool.name}, environment ${this.#environment}`);
    const request = {
      pool: this.#pool.name, environments: [this.#environment], size_px: SIZE_PX, frames_per_second_max: FRAMES_PER_SECOND,
    };
    this.#watch = new Watch(this.#connection, request,
      ([part]) => drawPart(byId("large-picture"), part), (message) => this.#say(message));
  }

  #stop() {
    this.#watch?.stop();
    this.#watch = null;
  }

  // Opens the trace of an episode in the replay page.
  async #keep(selector) {
    try {
      const pool = this.#pool.name;
      const episode = await this.#connection.call("pool.episode", { pool, environment: this.#environment, selector });
      replayTrace(partOf(episode, "trace").content, episode.file_name);
    } catch (error) {
      if (error.name !== "ServerError") {
        throw error;
      }
      this.#say(error.message);
    }
  }

  #say(text) {
    setText(byId("large-problem"), text);
  }
}
