// Watches environments of a pool: the server sends frames until the watch ends.

import { ServerError } from "../connection/connection.js";
import { FrameDecoder } from "../connection/frame_decoder.js";
import { attempt } from "../page.js";

export class Watch {
  #connection;
  #number = null;
  #isEnded = false;
  #decoder = new FrameDecoder();
  #onFrames;
  #onEnd;

  // `request`: pool, environments, size_px, frames_per_second_max. `onFrames(parts)` is called for each frame message,
  // `onEnd(message)` if the server ends it.
  constructor(connection, request, onFrames, onEnd) {
    this.#connection = connection;
    this.#onFrames = onFrames;
    this.#onEnd = onEnd;
    connection.addEventListener("message:frames", this.#receive);
    connection.addEventListener("message:watch_ended", this.#receiveEnd);
    this.#start(request);
  }

  stop() {
    this.#forget();
    if (this.#number !== null) {
      this.#connection.call("watch.stop", { watch: this.#number }).catch(ignoreGone);
    }
  }

  async #start(request) {
    const started = await attempt(() => this.#connection.call("watch.start", request));
    this.#number = started?.watch ?? null;
    if (this.#isEnded) {
      this.stop();
    }
  }

  #forget() {
    this.#isEnded = true;
    this.#connection.removeEventListener("message:frames", this.#receive);
    this.#connection.removeEventListener("message:watch_ended", this.#receiveEnd);
  }

  #receive = async ({ detail }) => {
    if (detail.watch === this.#number) {
      const parts = await this.#decoder.decode(detail.parts);
      if (!this.#isEnded) {
        this.#onFrames(parts);
      }
    }
  };

  #receiveEnd = ({ detail }) => {
    if (detail.watch === this.#number) {
      this.#number = null;
      this.#forget();
      this.#onEnd(detail.message);
    }
  };
}

// Ignores errors: the watch may have ended already.
function ignoreGone(error) {
  if (!(error instanceof ServerError)) {
    throw error;
  }
}
