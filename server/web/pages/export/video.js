// Encodes canvases as a WebM file, faster than in real time.

import { webm } from "./webm.js";

// VP9, 8 bits, up to 1280 x 720 at 30 frames per second or 512 x 512 at 60.
const CODEC = "vp09.00.31.08";
const BITS_PER_PIXEL = 0.5;  // per frame; pixel art has sharp edges
const KEY_FRAME_DISTANCE = 150;
const QUEUE_MAX = 8;

// Whether the browser encodes videos: most do so only on HTTPS and localhost, some never.
export function encodesVideo() {
  return typeof VideoEncoder !== "undefined";
}

export class Video {
  #options;
  #encoder;
  #frames = [];
  #count = 0;
  #error = null;

  // `options`: width, height, framesPerSecond.
  constructor(options) {
    this.#options = options;
    const { width, height, framesPerSecond } = options;
    this.#encoder = new VideoEncoder({
      output: (chunk) => this.#take(chunk),
      error: (error) => { this.#error = error; },
    });
    this.#encoder.configure({
      codec: CODEC, width, height, framerate: framesPerSecond,
      bitrate: Math.round(width * height * framesPerSecond * BITS_PER_PIXEL),
    });
  }

  // Adds a frame. Waits while the encoder is busy. Throws its error.
  async add(canvas) {
    const frame = new VideoFrame(canvas, { timestamp: Math.round(this.#count * 1e6 / this.#options.framesPerSecond) });
    this.#encoder.encode(frame, { keyFrame: this.#count % KEY_FRAME_DISTANCE === 0 });
    frame.close();
    this.#count += 1;
    while (this.#encoder.encodeQueueSize > QUEUE_MAX && !this.#error) {
      await new Promise((resolve) => { setTimeout(resolve); });
    }
    this.#check();
  }

  // The file, as a Blob. Throws the encoder's error.
  async finish() {
    await this.#encoder.flush().catch(() => {});
    this.#check();
    this.#encoder.close();
    const { width, height, framesPerSecond } = this.#options;
    return webm({ codec: "V_VP9", width, height, durationMs: this.#count * 1000 / framesPerSecond, frames: this.#frames });
  }

  cancel() {
    if (this.#encoder.state !== "closed") {
      this.#encoder.close();
    }
  }

  #take(chunk) {
    const bytes = new Uint8Array(chunk.byteLength);
    chunk.copyTo(bytes);
    this.#frames.push({ timeMs: Math.round(chunk.timestamp / 1000), isKey: chunk.type === "key", bytes });
  }

  #check() {
    if (this.#error) {
      throw this.#error;
    }
  }
}
