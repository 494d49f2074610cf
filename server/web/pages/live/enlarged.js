// A dialog with an enlarged environment: human view, agent view and newest step. Its episodes can be saved and replayed.

import { byId, setText } from "../elements/elements.js";
import { sentence } from "../elements/notices.js";
import { drawPart, partOf } from "../elements/pictures.js";
import { sourceOf } from "../links/replay_link.js";
import { replayTrace } from "../links/traces.js";
import { attempt } from "../page.js";
import { AnnotationView } from "./annotations.js";
import { EndHold, markEnd } from "./ends.js";
import { StepView } from "./step.js";
import { Watch } from "./watch.js";

const HUMAN_SIZE_PX = 512;
const AGENT_SIZE_PX = 64;
const FRAMES_PER_SECOND = 15;
// How long the end of an episode stays.
const END_SHOWN_MS = 700;

export class EnlargedView {
  #connection = null;
  #catalog = null;
  #pool = null;
  #environment = 0;
  #watches = [];
  #dialog = byId("large");
  #onToggle;
  #onChoose;
  #step = null;         // StepView of the environment
  #annotations = null;  // AnnotationView of the environment
  #human = new EndHold(END_SHOWN_MS, (part) => draw(part, "large-picture", "large-frame"));
  #agent = new EndHold(END_SHOWN_MS, (part) => {
    draw(part, "large-agent", "large-agent-frame");
    this.#step.show(part.step);
  });

  // `onToggle(isOpen)` is called when the dialog opens or closes, `onChoose(environment)` when an environment is shown; null:
  // the user has closed the dialog.
  constructor(onToggle, onChoose) {
    this.#onToggle = onToggle;
    this.#onChoose = onChoose;
    this.#dialog.addEventListener("close", () => {
      if (!this.#dialog.open) {  // not shown again meanwhile
        this.#stop();
        onToggle(false);
      }
    });
    this.#dialog.addEventListener("cancel", () => onChoose(null));
    this.#dialog.addEventListener("keydown", ({ key }) => {
      if (key === "ArrowLeft" || key === "ArrowRight") {
        this.#turn(key === "ArrowLeft" ? -1 : 1);
      }
    });
    byId("close").addEventListener("click", () => {
      onChoose(null);
      this.close();
    });
    byId("previous").addEventListener("click", () => this.#turn(-1));
    byId("following").addEventListener("click", () => this.#turn(1));
    byId("keep-last").addEventListener("click", () => this.#keep("last"));
    byId("keep-current").addEventListener("click", () => this.#keep("current"));
  }

  show(connection, catalog, pool, environment) {
    this.#connection = connection;
    this.#catalog = catalog;
    this.#pool = pool;
    this.#environment = environment;
    if (!this.#dialog.open) {
      this.#dialog.showModal();
      this.#onToggle(true);
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
    this.#onChoose(this.#environment);
    this.#say("");
    setText(byId("large-title"), `${this.#pool.name}, environment ${this.#environment}`);
    const { name, games } = this.#pool;
    this.#step = new StepView(this.#catalog, games[this.#environment % games.length]);
    this.#annotations = new AnnotationView(byId("large-annotations"), this.#catalog.actions);
    this.#watch({ pool: name, size_px: HUMAN_SIZE_PX }, (part) => this.#human.show(part));
    this.#watch({ pool: name, size_px: AGENT_SIZE_PX, with_steps: true }, (part) => {
      this.#annotations.add(part.step);
      this.#agent.show(part);
    });
  }

  // The views have watches of their own, because people's view is drawn less often while the machine is busy.
  #watch(what, show) {
    const request = { ...what, environments: [this.#environment], frames_per_second_max: FRAMES_PER_SECOND };
    this.#watches.push(new Watch(this.#connection, request, ([part]) => show(part), (message) => this.#say(sentence(message))));
  }

  #stop() {
    this.#watches.forEach((watch) => watch.stop());
    this.#watches = [];
    this.#human.clear();
    this.#agent.clear();
    markEnd(byId("large-frame"), null);
    markEnd(byId("large-agent-frame"), null);
  }

  // Opens the trace of an episode in the replay page.
  async #keep(selector) {
    const request = { pool: this.#pool.name, environment: this.#environment, selector };
    const episode = await attempt(() => this.#connection.call("pool.episode", request), (text) => this.#say(text));
    if (episode) {
      replayTrace(partOf(episode, "trace").content, episode.file_name, sourceOf(episode));
    }
  }

  #say(text) {
    setText(byId("large-problem"), text);
  }
}

async function draw(part, canvas, frame) {
  await drawPart(byId(canvas), part);
  markEnd(byId(frame), part.ended_episode, part.width === AGENT_SIZE_PX);
}
