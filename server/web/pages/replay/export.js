// A dialog that saves a frame of a replay as PNG, or all frames as a video, in either view and several sizes.

import { byId, element, setText } from "../elements/elements.js";
import { plural } from "../elements/figures.js";
import { drawImage } from "../elements/pictures.js";
import { saveFile } from "../export/files.js";
import { pageFile } from "../export/page_file.js";
import { Video, videoFormats } from "../export/video.js";
import { AGENT_SIZE_PX } from "../run/environment.js";
import { FRAMES_PER_SECOND_MAX, STEPS_PER_SECOND } from "./player.js";
import { Rows } from "./rows.js";
import { imageOf } from "./view.js";

const ROWS_AHEAD = 4;
const STOPPED = "The connection was lost.";

export class ExportDialog {
  #dialog = byId("export");
  #current;
  #isCancelled = false;
  #formats = [];  // that the browser encodes

  // `current()` returns what the page shows: { replay, frames, index, speed, name }, texts(frame), and the values(frames) of the learner.
  constructor(current) {
    this.#current = current;
    byId("export-image").addEventListener("click", () => this.#run((rows) => this.#saveImage(rows)));
    byId("export-video").addEventListener("click", () => this.#run((rows) => this.#saveVideo(rows)));
    byId("export-page").addEventListener("click", () => this.#run(() => this.#savePage()));
    byId("export-cancel").addEventListener("click", () => this.#cancel());
    byId("export-close").addEventListener("click", () => this.#dialog.close());
    this.#dialog.addEventListener("close", () => this.#cancel());
  }

  async show() {
    this.#formats = await videoFormats();
    for (const option of byId("export-format").options) {
      option.disabled = this.#formats.length > 0 && !this.#formats.includes(option.value);
    }
    const { frames, index, speed } = this.#current();
    setText(byId("export-image"), `Save image of step ${frames.at(index).row}`);
    setText(byId("export-about"), this.#formats.length > 0
      ? `The video has the whole replay at ${speed}× speed, ${plural(Math.ceil(this.#durationS()), "second")}.`
      : isSecureContext ? "This browser does not encode videos." : "This browser encodes videos only on HTTPS and localhost.");
    byId("export-video").disabled = this.#formats.length === 0;
    this.#say("");
    this.#dialog.showModal();
  }

  #durationS() {
    const { frames, speed } = this.#current();
    return (frames.last + 1) / (STEPS_PER_SECOND * speed);
  }

  get #view() {
    return byId("export-view").value;
  }

  get #sizePx() {
    return AGENT_SIZE_PX * Number(byId("export-scale").value);
  }

  get #name() {
    return `${this.#current().replay.recording.fileName.replace(/\.trace$/, "")}.${this.#view}`;
  }

  #cancel() {
    this.#isCancelled = true;
  }

  // Runs `work(rows)` with images of the chosen size.
  async #run(work) {
    this.#isCancelled = false;
    this.#setBusy(true);
    try {
      await work(new Rows(this.#current().replay, this.#view === "human" ? this.#sizePx : AGENT_SIZE_PX));
    } catch (error) {
      this.#say(error.message);
    }
    this.#setBusy(false);
  }

  async #saveImage(rows) {
    const { frames, index } = this.#current();
    const canvas = this.#canvas();
    await this.#draw(canvas, rows, [index]);
    const name = `${this.#name}.step-${frames.at(index).row}.png`;
    saveFile(await new Promise((resolve) => { canvas.toBlob(resolve); }), name);
    this.#say(`Saved ${name}.`);
  }

  async #saveVideo(rows) {
    const { frames, speed } = this.#current();
    const stride = Math.ceil(STEPS_PER_SECOND * speed / FRAMES_PER_SECOND_MAX);
    const indexes = Array.from({ length: Math.floor(frames.last / stride) + 1 }, (_, i) => i * stride);
    const canvas = this.#canvas();
    const format = byId("export-format").value;
    const video = await Video.start({ format, width: canvas.width, height: canvas.height, framesPerSecond: STEPS_PER_SECOND * speed / stride });
    try {
      for (let i = 0; i < indexes.length && !this.#isCancelled; i += 1) {
        await this.#draw(canvas, rows, indexes.slice(i, i + ROWS_AHEAD));
        await video.add(canvas);
        byId("export-progress").value = (i + 1) / indexes.length;
        this.#say(`Frame ${i + 1} of ${indexes.length}.`);
      }
      if (this.#isCancelled) {
        this.#say("Cancelled.");
        return;
      }
      const name = `${this.#name}.${format}`;
      saveFile(await video.finish(), name);
      this.#say(`Saved ${name}.`);
    } finally {
      video.cancel();
    }
  }

  // Saves all frames of the agent's view as a web page.
  async #savePage() {
    const { replay, frames, name, texts, values } = this.#current();
    const rows = new Rows(replay, AGENT_SIZE_PX);
    const all = Array.from({ length: frames.last + 1 }, (_, i) => frames.at(i));
    const images = [];
    for (let i = 0; i < all.length && !this.#isCancelled; i += 1) {
      const view = await rows.fetch([...new Set(all.slice(i, i + ROWS_AHEAD).map(({ row }) => row))]);
      if (!view) {
        throw new Error(STOPPED);
      }
      images.push(imageOf(view, all[i], "agent").content);
      byId("export-progress").value = (i + 1) / all.length;
    }
    if (this.#isCancelled) {
      this.#say("Cancelled.");
      return;
    }
    const file = `${this.#name}.html`;
    saveFile(await pageFile({ title: name, about: byId("level").textContent, size: AGENT_SIZE_PX, images, texts: all.map(texts), values: values(all) }), file);
    this.#say(`Saved ${file}.`);
  }

  // Draws the first of some frames, and requests the rows of all.
  async #draw(canvas, rows, indexes) {
    const { frames } = this.#current();
    const wanted = indexes.map((index) => frames.at(index));
    const view = await rows.fetch([...new Set(wanted.map(({ row }) => row))]);
    if (!view) {
      throw new Error(STOPPED);
    }
    const image = element("canvas");
    await drawImage(image, imageOf(view, wanted[0], this.#view));
    canvas.getContext("2d").drawImage(image, 0, 0, canvas.width, canvas.height);
  }

  #canvas() {
    const canvas = element("canvas", { width: this.#sizePx, height: this.#sizePx });
    canvas.getContext("2d", { alpha: false }).imageSmoothingEnabled = false;
    return canvas;
  }

  #setBusy(isBusy) {
    for (const id of ["export-image", "export-page", "export-view", "export-scale", "export-format"]) {
      byId(id).disabled = isBusy;
    }
    byId("export-video").disabled = isBusy || this.#formats.length === 0;
    byId("export-progress").hidden = !isBusy;
    byId("export-progress").value = 0;
    byId("export-cancel").hidden = !isBusy;
  }

  #say(text) {
    setText(byId("export-state"), text);
  }
}
