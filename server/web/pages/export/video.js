// Encodes canvases as a WebM or MP4 file, faster than in real time.

const BITS_PER_PIXEL = 0.5;  // per frame; pixel art has sharp edges
const KEY_FRAME_DISTANCE = 150;
const QUEUE_MAX = 8;

// By the extension of the file: the codec's name for the encoder and the one for the muxer. VP9 of 8 bits, and H.264 High, up to
// 1280 x 720 at 30 frames a second or 1024 x 1024 at 15.
const FORMATS = {
  webm: { codec: "vp09.00.31.08", track: "V_VP9", type: "video/webm" },
  mp4: { codec: "avc1.640028", track: "avc", type: "video/mp4" },
};

// The formats that this browser encodes, "webm" or "mp4": most browsers encode only on HTTPS and localhost, some never.
export async function videoFormats() {
  if (typeof VideoEncoder === "undefined") {
    return [];
  }
  const names = Object.keys(FORMATS);
  const answers = await Promise.all(names.map((name) => VideoEncoder.isConfigSupported(configOf(name, { width: 512, height: 512, framesPerSecond: 30 }))));
  return names.filter((_, i) => answers[i].supported);
}

function configOf(format, { width, height, framesPerSecond }) {
  return { codec: FORMATS[format].codec, width, height, framerate: framesPerSecond, bitrate: Math.round(width * height * framesPerSecond * BITS_PER_PIXEL) };
}

export class Video {
  #format;
  #framesPerSecond;
  #muxer;
  #encoder;
  #count = 0;
  #canvas = null;  // of the last frame
  #error = null;

  // `options`: format, width, height (even for MP4), framesPerSecond.
  static async start(options) {
    return new Video(options, await import("../vendor/muxers.js"));
  }

  constructor(options, { Mp4Muxer, Mp4Target, WebMMuxer, WebMTarget }) {
    const { format, width, height, framesPerSecond } = options;
    const video = { codec: FORMATS[format].track, width, height, frameRate: framesPerSecond };
    this.#format = format;
    this.#framesPerSecond = framesPerSecond;
    this.#muxer = format === "mp4" ? new Mp4Muxer({ target: new Mp4Target(), video, fastStart: "in-memory" })
      : new WebMMuxer({ target: new WebMTarget(), video });
    this.#encoder = new VideoEncoder({
      output: (chunk, metadata) => this.#muxer.addVideoChunk(chunk, metadata),
      error: (error) => { this.#error = error; },
    });
    this.#encoder.configure(configOf(format, options));
  }

  // Adds a frame. Waits while the encoder is busy. Throws its error.
  async add(canvas) {
    this.#canvas = canvas;
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
    if (this.#format === "webm" && this.#canvas) {
      await this.add(this.#canvas);  // A WebM file ends with the start of its last frame.
    }
    await this.#encoder.flush().catch(() => {});
    this.#check();
    this.#encoder.close();
    this.#muxer.finalize();
    return new Blob([this.#muxer.target.buffer], { type: FORMATS[this.#format].type });
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
