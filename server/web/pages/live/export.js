// Saves the environments that are shown side by side: as an image, or, while a button is pressed, as a video.

import { byId, element, setText } from "../elements/elements.js";
import { plural } from "../elements/figures.js";
import { notify, sentence } from "../elements/notices.js";
import { saveFile } from "../export/files.js";
import { Video, videoFormats } from "../export/video.js";

const FORMAT = "webm";
const GAP_PX = 2;
const FRAMES_PER_SECOND = 15;
const VIDEO_SIZE_PX_MAX = 1024;
const VIDEO_DURATION_S_MAX = 600;

export class MosaicExport {
  #current;
  #recording = null;  // { video, canvas, name, timer, count: number of frames }

  // `current()` returns what is shown: { name: of the pool, canvases }.
  constructor(current) {
    this.#current = current;
    byId("mosaic-image").addEventListener("click", () => this.#saveImage());
    byId("mosaic-video").addEventListener("click", () => (this.#recording ? this.stop() : this.#record()));
    byId("mosaic-video").disabled = true;
    videoFormats().then((formats) => {
      byId("mosaic-video").disabled = !formats.includes(FORMAT);
      byId("mosaic-video").title = formats.includes(FORMAT) ? "" : "This browser encodes no videos here";
    });
  }

  // Ends a recording and saves it.
  async stop() {
    const recording = this.#recording;
    if (!recording) {
      return;
    }
    this.#recording = null;
    clearInterval(recording.timer);
    this.#showState(null);
    try {
      saveFile(await recording.video.finish(), `${recording.name}.${FORMAT}`);
    } catch (error) {
      notify(sentence(error.message), "bad");
    } finally {
      recording.video.cancel();
    }
  }

  async #saveImage() {
    const { name, canvases } = this.#current();
    const canvas = makeCanvas(canvases, Infinity);
    drawAll(canvas, canvases);
    saveFile(await new Promise((resolve) => { canvas.toBlob(resolve); }), `${nameOf(name)}.png`);
  }

  async #record() {
    const { name, canvases } = this.#current();
    const canvas = makeCanvas(canvases, VIDEO_SIZE_PX_MAX);
    byId("mosaic-video").disabled = true;
    const video = await Video.start({ format: FORMAT, width: canvas.width, height: canvas.height, framesPerSecond: FRAMES_PER_SECOND });
    byId("mosaic-video").disabled = false;
    this.#recording = { video, canvas, name: nameOf(name), count: 0, timer: setInterval(() => this.#add(), 1000 / FRAMES_PER_SECOND) };
    this.#add();
  }

  async #add() {
    const recording = this.#recording;
    recording.count += 1;
    this.#showState(recording.count / FRAMES_PER_SECOND);
    drawAll(recording.canvas, this.#current().canvases);
    try {
      await recording.video.add(recording.canvas);
    } catch {
      this.stop();  // It reports the error.
    }
    if (recording.count >= VIDEO_DURATION_S_MAX * FRAMES_PER_SECOND) {
      this.stop();
    }
  }

  #showState(durationS) {
    const button = byId("mosaic-video");
    button.setAttribute("aria-pressed", String(durationS !== null));
    setText(button, durationS === null ? "Record video" : `Stop after ${plural(Math.floor(durationS), "second")}`);
  }
}

function nameOf(pool) {
  return `${pool.replace(/^pools\//, "")}.mosaic`;
}

function columnsOf(canvases) {
  return Math.ceil(Math.sqrt(canvases.length));
}

// A canvas with room for all; its sides are at most `sizeMax`.
function makeCanvas(canvases, sizeMax) {
  const columns = columnsOf(canvases);
  const rows = Math.ceil(canvases.length / columns);
  const cell = Math.min(canvases[0].width, Math.floor(sizeMax / columns) - GAP_PX);
  return element("canvas", { width: columns * (cell + GAP_PX) - GAP_PX, height: rows * (cell + GAP_PX) - GAP_PX });
}

function drawAll(canvas, canvases) {
  const columns = columnsOf(canvases);
  const step = (canvas.width + GAP_PX) / columns;
  const context = canvas.getContext("2d", { alpha: false });
  canvases.forEach((each, i) => context.drawImage(
    each, (i % columns) * step, Math.floor(i / columns) * step, step - GAP_PX, step - GAP_PX));
}
