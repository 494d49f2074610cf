// Watches environments of a pool: the server sends frames until the watch ends.

import { DeltaDecoder } from "../connection/delta.js";
import { LOST } from "../connection/errors.js";
import { attempt } from "../page.js";
import { AGENT_SIZE_PX } from "../run/environment.js";

const FRAME_FORMAT_RGB = 1;
const FRAME_FORMAT_PNG = 2;
const ENCODING_RAW = 1;
const ENCODING_DELTA_ZSTD = 2;

export class Watch {
  #call = null;
  #decoder = new DeltaDecoder();
  #onFrames;
  #onEnd;

  // `request`: pool, environments, sizePx, framesPerSecondMax, withSteps, withAgentViews. `onFrames(frames)` is called with each
  // response: images with `environment`, `agent`: the agent's view, `endedEpisode` and `step`. `onEnd(message)` is called if the server
  // ends the watch.
  constructor(connection, request, onFrames, onEnd) {
    this.#onFrames = onFrames;
    this.#onEnd = onEnd;
    const isAgent = request.sizePx === AGENT_SIZE_PX;
    attempt(() => {
      this.#call = connection.watch("PoolService.WatchPool", {
        ...request, format: isAgent ? FRAME_FORMAT_RGB : FRAME_FORMAT_PNG, encoding: isAgent ? ENCODING_DELTA_ZSTD : ENCODING_RAW,
      }, (response) => this.#receive(response), (error) => this.#end(error));
    });
  }

  stop() {
    this.#call?.cancel();
    this.#call = null;
  }

  #receive({ frames, encodedImages }) {
    const images = encodedImages.length > 0 ? this.#decoder.decode(encodedImages, frames.map((_, i) => i)) : null;
    this.#onFrames(frames.map((frame, i) => ({
      environment: frame.environment, format: images ? "rgb" : "png", width: frame.sizePx, height: frame.sizePx,
      content: images ? images[i] : frame.image, endedEpisode: episodeOf(frame.endedEpisode), step: stepOf(frame.step),
      agent: { format: "png", width: AGENT_SIZE_PX, height: AGENT_SIZE_PX, content: frame.agentImage },
    })));
  }

  #end(error) {
    this.#call = null;
    if (error && error.code !== LOST) {
      this.#onEnd(error.message);
    }
  }
}

// The episode that a frame shows the end of: { return, length, levelSeed, levelComplete, truncated }, or null.
function episodeOf(episode) {
  return episode ? { ...episode, return: episode.episodeReturn, length: episode.episodeLength } : null;
}

// A step of an environment: { action: null at the start of an episode, reward, return, length, levelSeed, annotations }, or undefined.
// Values that are not finite are null.
function stepOf(step) {
  return step && {
    ...step, action: step.action ?? null, return: step.episodeReturn, length: step.episodeLength,
    annotations: step.annotations.map(({ name, values }) => ({ name, values: values.map((value) => (Number.isFinite(value) ? value : null)) })),
  };
}
