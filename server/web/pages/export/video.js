// Encodes canvases as an MP4 file, faster than in real time.

const BITS_PER_PIXEL = 0.5;  // per frame; pixel art has sharp edges
const KEY_FRAME_DISTANCE = 150;
const QUEUE_MAX = 8;

// H.264 Baseline, whose frames are in order as the muxer needs them, and, for browsers that do not encode it, VP9 of 8 bits: their names
// for the encoder and for the muxer.
const CODECS = [{ name: "avc1.42001f", track: "avc" }, { name: "vp09.00.31.08", track: "vp9" }];

// The first codec that this browser encodes, or null: most browsers encode only on HTTPS and localhost, some never.
export async function videoCodec() {
  if (typeof VideoEncoder === "undefined") {
    return null;
  }
  const answers = await Promise.all(CODECS.map((codec) => VideoEncoder.isConfigSupported(configOf({ codec, size: 512, framesPerSecond: 30 }))));
  return CODECS.find((_, i) => answers[i].supported) ?? null;
}

function configOf({ codec, size, framesPerSecond }) {
  const bitrate = Math.round(size * size * framesPerSecond * BITS_PER_PIXEL);
  return { codec: codec.name, width: size, height: size, framerate: framesPerSecond, bitrate };
}

export class Video {
  #framesPerSecond;
  #muxer;
  #encoder;
  #count = 0;
  #error = null;

  // `options`: codec, size in pixels (even), framesPerSecond.
  static async start(options) {
    return new Video(options, await import("../vendor/muxer.js"));
  }

  constructor(options, { Muxer, ArrayBufferTarget }) {
    const { codec, size, framesPerSecond } = options;
    this.#framesPerSecond = framesPerSecond;
    const video = { codec: codec.track, width: size, height: size, frameRate: framesPerSecond };
    this.#muxer = new Muxer({ target: new ArrayBufferTarget(), video, fastStart: "in-memory" });
    this.#encoder = new VideoEncoder({
      output: (chunk, metadata) => this.#muxer.addVideoChunk(chunk, metadata),
      error: (error) => { this.#error = error; },
    });
    this.#encoder.configure(configOf(options));
  }

  // Adds a frame. Waits while the encoder is busy. Throws its error.
  async add(canvas) {
    const duration = 1e6 / this.#framesPerSecond;
    const frame = new VideoFrame(canvas, { timestamp: Math.round(this.#count * duration), duration: Math.round(duration) });
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
    this.#muxer.finalize();
    return new Blob([this.#muxer.target.buffer], { type: "video/mp4" });
  }

  cancel() {
    if (this.#encoder.state !== "closed") {
      this.#encoder.close();
    }
  }

  #check() {
    if (this.#error) {
      throw this.#error;
    }
  }
}
