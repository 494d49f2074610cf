// A dialog with an enlarged environment: both views of its newest step, and the step. Its episodes can be saved and replayed.

import { drawSaliency, splitSaliency } from "../elements/annotations.js";
import { byId, setText } from "../elements/elements.js";
import { sentence } from "../elements/notices.js";
import { drawImage } from "../elements/pictures.js";
import { attempt } from "../page.js";
import { AnnotationView } from "./annotations.js";
import { EndHold, markEnd } from "./ends.js";
import { openEpisode } from "./open_episode.js";
import { StepView } from "./step.js";
import { Watch } from "./watch.js";

const HUMAN_SIZE_PX = 512;
const FRAMES_PER_SECOND = 15;
// How long the end of an episode stays.
const END_SHOWN_MS = 700;

export class EnlargedView {
  #connection = null;
  #catalog = null;
  #pool = null;
  #environment = 0;
  #watch = null;
  #dialog = byId("large");
  #onToggle;
  #onChoose;
  #step = null;         // StepView of the environment
  #annotations = null;  // AnnotationView of the environment
  #hold = new EndHold(END_SHOWN_MS, (frame) => this.#draw(frame));

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
    const { envCount: all } = this.#pool;
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
    const request = {
      pool: name, environments: [this.#environment], sizePx: HUMAN_SIZE_PX, framesPerSecondMax: FRAMES_PER_SECOND,
      withSteps: true, withAgentViews: true,
    };
    this.#watch = new Watch(this.#connection, request, ([frame]) => this.#receive(frame), (message) => this.#say(sentence(message)));
  }

  #receive(frame) {
    if (frame.step) {
      const { map, others } = splitSaliency(frame.step.annotations);
      frame.saliency = map;
      this.#annotations.add(frame.step, others);
    }
    this.#hold.show(frame);
  }

  async #draw(frame) {
    await Promise.all([drawImage(byId("large-picture"), frame), drawImage(byId("large-agent"), frame.agent)]);
    drawSaliency(byId("large-saliency"), frame.saliency ?? null);
    markEnd(byId("large-frame"), frame.endedEpisode);
    markEnd(byId("large-agent-frame"), frame.endedEpisode, true);
    this.#step.show(frame.step);
  }

  #stop() {
    this.#watch?.stop();
    this.#watch = null;
    this.#hold.clear();
    markEnd(byId("large-frame"), null);
    markEnd(byId("large-agent-frame"), null);
  }

  // Opens an episode in the replay page. `episode`: "last" or "current".
  #keep(episode) {
    return attempt(() => openEpisode(this.#connection, { pool: this.#pool.name, environment: this.#environment, episode }),
      (text) => this.#say(text));
  }

  #say(text) {
    setText(byId("large-problem"), text);
  }
}
