// A dialog with an enlarged environment: human view, agent view and newest step. Its episodes can be saved and replayed.

import { byId, setText } from "../elements/elements.js";
import { count } from "../elements/figures.js";
import { sentence } from "../elements/notices.js";
import { drawImage } from "../elements/pictures.js";
import { attempt } from "../page.js";
import { AGENT_SIZE_PX } from "../run/environment.js";
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
  #watches = [];
  #dialog = byId("large");
  #onToggle;
  #onChoose;
  #step = null;         // StepView of the environment
  #annotations = null;  // AnnotationView of the environment
  #human = new EndHold(END_SHOWN_MS, (image) => {
    draw(image, "large-picture", "large-frame");
    setText(byId("large-human-step"), captionOf("Human view", image.step));
  });
  #agent = new EndHold(END_SHOWN_MS, (image) => {
    draw(image, "large-agent", "large-agent-frame");
    setText(byId("large-agent-step"), captionOf("Agent view", image.step));
    this.#step.show(image.step);
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
    this.#watch({ pool: name, sizePx: HUMAN_SIZE_PX, withSteps: true }, (image) => this.#human.show(image));
    this.#watch({ pool: name, sizePx: AGENT_SIZE_PX, withSteps: true }, (image) => {
      this.#annotations.add(image.step);
      this.#agent.show(image);
    });
  }

  // Each view has a watch of its own.
  #watch(what, show) {
    const request = { ...what, environments: [this.#environment], framesPerSecondMax: FRAMES_PER_SECOND };
    this.#watches.push(new Watch(this.#connection, request, ([image]) => show(image), (message) => this.#say(sentence(message))));
  }

  #stop() {
    this.#watches.forEach((watch) => watch.stop());
    this.#watches = [];
    this.#human.clear();
    this.#agent.clear();
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

// The views may show different steps, because people's view is drawn less often while the machine is busy.
function captionOf(name, step) {
  return step ? `${name}, step ${count(step.length)}` : name;
}

async function draw(image, canvas, frame) {
  await drawImage(byId(canvas), image);
  markEnd(byId(frame), image.endedEpisode, image.width === AGENT_SIZE_PX);
}
