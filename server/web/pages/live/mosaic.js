// The environments of a pool side by side, with controls for selection, size and rate.

import { byId, element, setText } from "../elements/elements.js";
import { notify, sentence } from "../elements/notices.js";
import { drawImage } from "../elements/pictures.js";
import { AGENT_SIZE_PX } from "../run/environment.js";
import { EndHold, markEnd } from "./ends.js";
import { Watch } from "./watch.js";

// How long the end of an episode stays.
const END_SHOWN_MS = 400;

export class Mosaic {
  #connection = null;
  #pool = null;
  #watch = null;
  #first = 0;
  #canvases = new Map();  // environment -> canvas
  #holds = new Map();     // environment -> EndHold
  #onChoose;
  #isCovered = false;

  // `onChoose(pool, environment)` is called when one is clicked.
  constructor(onChoose) {
    this.#onChoose = onChoose;
    if (matchMedia("(prefers-reduced-motion: reduce)").matches) {
      byId("rate").value = "1";
    }
    for (const control of [byId("shown"), byId("rate"), ...document.querySelectorAll("[name=size]")]) {
      control.addEventListener("change", () => this.#begin());
    }
    byId("earlier").addEventListener("click", () => this.#turnTo(this.#first - this.#shown));
    byId("later").addEventListener("click", () => this.#turnTo(this.#first + this.#shown));
    byId("first").addEventListener("change", ({ target }) => this.#turnTo(target.valueAsNumber || 0));
    byId("hold").addEventListener("click", ({ target }) => {
      target.setAttribute("aria-pressed", String(target.getAttribute("aria-pressed") !== "true"));
      this.#begin();
    });
    document.addEventListener("visibilitychange", () => this.#begin());
  }

  // Shows a pool, starting at its first environment; null shows none.
  open(connection, pool) {
    this.#connection = connection;
    this.#pool = pool ?? null;
    this.#first = 0;
    this.#begin();
  }

  // Stops watching; the images stay.
  stop() {
    this.#end();
    this.#connection = null;
  }

  // Stops while a dialog covers the environments.
  cover(value) {
    this.#isCovered = value;
    this.#begin();
  }

  get #shown() {
    return Number(byId("shown").value);
  }

  #turnTo(environment) {
    this.#first = Math.max(0, Math.min(environment, this.#pool.envCount - 1));
    this.#begin();
  }

  #end() {
    this.#watch?.stop();
    this.#watch = null;
    this.#holds.forEach((hold) => hold.clear());
  }

  // Starts a watch with the settings of the controls.
  #begin() {
    this.#end();
    if (!this.#connection || !this.#pool) {
      return;
    }
    const { name, envCount: all } = this.#pool;
    const environments = Array.from({ length: Math.min(this.#shown, all - this.#first) }, (_, i) => this.#first + i);
    const size = Number(sizeInput().value);
    this.#layOut(environments, size, all);
    const isHeld = byId("hold").getAttribute("aria-pressed") === "true";
    if (isHeld || document.hidden || this.#isCovered) {
      return;
    }
    const request = { pool: name, environments, sizePx: size, framesPerSecondMax: Number(byId("rate").value) };
    this.#watch = new Watch(this.#connection, request,
      (frames) => frames.forEach((frame) => this.#holds.get(frame.environment).show(frame)),
      (message) => notify(sentence(message), "warn"));
  }

  #layOut(environments, size, all) {
    const last = environments.at(-1);
    byId("first").value = environments[0];
    byId("first").max = all - 1;
    setText(byId("range"), `to ${last} of ${all}`);
    byId("earlier").disabled = environments[0] === 0;
    byId("later").disabled = last === all - 1;
    const list = byId("mosaic");
    list.style.setProperty("--columns", Math.ceil(Math.sqrt(environments.length)));
    const isSame = environments.every((environment) => this.#canvases.has(environment))
      && this.#canvases.size === environments.length && list.dataset.pool === this.#pool.name;
    if (!isSame) {
      list.dataset.pool = this.#pool.name;
      this.#canvases = new Map(environments.map((environment) =>
        [environment, element("canvas", {
          width: AGENT_SIZE_PX, height: AGENT_SIZE_PX, role: "img", "aria-label": `Enlarge environment ${environment}`,
        })]));
      this.#holds = new Map([...this.#canvases].map(([environment, canvas]) => [environment, new EndHold(END_SHOWN_MS, async (frame) => {
        await drawImage(canvas, frame);
        markEnd(canvas.parentElement, frame.endedEpisode, true);
      })]));
      list.replaceChildren(...[...this.#canvases].map(([environment, canvas]) => element("li", {},
        element("button", {
          type: "button", title: `Environment ${environment}`,
          onclick: () => this.#onChoose(this.#pool, environment),
        }, canvas))));
    }
    this.#canvases.forEach((canvas) => canvas.classList.toggle("pixels", size === AGENT_SIZE_PX));
  }
}

/** @returns {any} */
function sizeInput() {
  return document.querySelector("[name=size]:checked");
}
