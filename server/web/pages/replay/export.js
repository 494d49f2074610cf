// A dialog that saves a frame of a replay as PNG, all frames in either view as a video, or those of the agent's view as a web page.

import { byId, element, setText } from "../elements/elements.js";
import { plural } from "../elements/figures.js";
import { drawImage } from "../elements/pictures.js";
import { saveFile } from "../export/files.js";
import { pageFile } from "../export/page_file.js";
import { Video, videoCodec } from "../export/video.js";
import { AGENT_SIZE_PX } from "../run/environment.js";
import { FRAMES_PER_SECOND_MAX, STEPS_PER_SECOND } from "./player.js";
import { Rows } from "./rows.js";
import { imageOf } from "./view.js";

const SIZE_PX = 512;
const ROWS_AHEAD = 4;

export class ExportDialog {
  #dialog = byId("export");
  #current;
  #isCancelled = false;
  #codec = null;  // that the browser encodes

  // `current()` returns what the page shows: { replay, frames, index, speed, name }, texts(frame), and the values of the learner.
  constructor(current) {
    this.#current = current;
    byId("export-image").addEventListener("click", () => this.#run(() => this.#saveImage()));
    byId("export-video").addEventListener("click", () => this.#run(() => this.#saveVideo()));
    byId("export-page").addEventListener("click", () => this.#run(() => this.#savePage()));
    byId("export-cancel").addEventListener("click", () => { this.#isCancelled = true; });
    byId("export-close").addEventListener("click", () => this.#dialog.close());
    this.#dialog.addEventListener("close", () => { this.#isCancelled = true; });
  }

  async show() {
    this.#codec = await videoCodec();
    const { frames, index, speed } = this.#current();
    const durationS = (frames.last + 1) / (STEPS_PER_SECOND * speed);
    setText(byId("export-image"), `Save image of step ${frames.at(index).row}`);
    setText(byId("export-about"), this.#codec !== null ? `The video has the whole replay at ${speed}× speed, ${plural(Math.ceil(durationS), "second")}.`
      : isSecureContext ? "This browser does not encode videos." : "This browser encodes videos only on HTTPS and localhost.");
    byId("export-video").disabled = this.#codec === null;
    this.#say("");
    this.#dialog.showModal();
  }

  // Runs `work()`, which resolves to a file, { content: a Blob, suffix }, or to null if it was cancelled, and saves the file.
  async #run(work) {
    this.#isCancelled = false;
    this.#setBusy(true);
    try {
      const file = await work();
      if (file) {
        const name = `${this.#current().replay.recording.fileName.replace(/\.trace$/, "")}.${file.suffix}`;
        saveFile(file.content, name);
        this.#say(`Saved ${name}.`);
      } else {
        this.#say("Cancelled.");
      }
    } catch (error) {
      this.#say(error.message);
    }
    this.#setBusy(false);
  }

  get #view() {
    return byId("export-view").value;
  }

  async #saveImage() {
    const { frames, index } = this.#current();
    const canvas = makeCanvas();
    await this.#each([frames.at(index)], this.#view, (image) => draw(canvas, image));
    const content = await new Promise((resolve) => { canvas.toBlob(resolve); });
    return { content, suffix: `${this.#view}.step-${frames.at(index).row}.png` };
  }

  async #saveVideo() {
    const { frames, speed } = this.#current();
    const stride = Math.ceil(STEPS_PER_SECOND * speed / FRAMES_PER_SECOND_MAX);
    const shown = Array.from({ length: Math.floor(frames.last / stride) + 1 }, (_, i) => frames.at(i * stride));
    const canvas = makeCanvas();
    const video = await Video.start({ codec: this.#codec, size: SIZE_PX, framesPerSecond: STEPS_PER_SECOND * speed / stride });
    try {
      const isComplete = await this.#each(shown, this.#view, async (image) => {
        await draw(canvas, image);
        await video.add(canvas);
      });
      return isComplete ? { content: await video.finish(), suffix: `${this.#view}.mp4` } : null;
    } finally {
      video.cancel();
    }
  }

  async #savePage() {
    const { frames, name, texts, values } = this.#current();
    const all = Array.from({ length: frames.last + 1 }, (_, i) => frames.at(i));
    const images = [];
    if (!await this.#each(all, "agent", ({ content }) => images.push(content))) {
      return null;
    }
    const about = byId("level").textContent;
    return { content: await pageFile({ title: name, about, size: AGENT_SIZE_PX, images, texts: all.map(texts), values }), suffix: "html" };
  }

  // Calls `use(image)` with the image of each frame, one after the other. Resolves to whether all were used: false if it was cancelled.
  async #each(frames, view, use) {
    const rows = new Rows(this.#current().replay, view === "human" ? SIZE_PX : AGENT_SIZE_PX);
    for (let i = 0; i < frames.length && !this.#isCancelled; i += 1) {
      const row = await rows.fetch([...new Set(frames.slice(i, i + ROWS_AHEAD).map((frame) => frame.row))]);
      if (!row) {
        throw new Error("The connection was lost.");
      }
      await use(imageOf(row, frames[i], view));
      byId("export-progress").value = (i + 1) / frames.length;
      this.#say(`Frame ${i + 1} of ${frames.length}.`);
    }
    return !this.#isCancelled;
  }

  #setBusy(isBusy) {
    for (const id of ["export-image", "export-page", "export-view"]) {
      byId(id).disabled = isBusy;
    }
    byId("export-video").disabled = isBusy || this.#codec === null;
    byId("export-progress").hidden = !isBusy;
    byId("export-progress").value = 0;
    byId("export-cancel").hidden = !isBusy;
  }

  #say(text) {
    setText(byId("export-state"), text);
  }
}

function makeCanvas() {
  const canvas = element("canvas", { width: SIZE_PX, height: SIZE_PX });
  canvas.getContext("2d", { alpha: false }).imageSmoothingEnabled = false;
  return canvas;
}

// Draws an image as large as a canvas.
async function draw(canvas, image) {
  const exact = element("canvas");
  await drawImage(exact, image);
  canvas.getContext("2d").drawImage(exact, 0, 0, canvas.width, canvas.height);
}
