// Images of levels, from a pool that lives as long as they are drawn.

import { PoolStream } from "./pool_stream.js";
import { levelSpec } from "./spec.js";

const FRAME_VIEW_HUMAN = 1;
const FRAME_VIEW_LEVEL = 3;
const FRAME_FORMAT_PNG = 2;

// The first images of `count` levels from a choice { game, mode, level, options, whole } on, as { level, image }. `whole`: the whole
// level, else what the player sees. `isOnly`: the mode has no other level. Rejects with a UserError.
export async function levelImages(connection, choice, isOnly, count, sizePx) {
  const pool = await PoolStream.start(connection, "gallery", levelSpec(choice, isOnly, count));
  try {
    const levels = Array.from({ length: count }, (_, i) => choice.level + i);
    if (!isOnly) {
      pool.request("reset", {
        slice: { envCount: count }, resets: levels.map((levelSeed, environment) => ({ environment, levelSeed })), acknowledgeOnly: true,
      });
    }
    const { frames } = await pool.request("render", {
      environments: levels.map((_, i) => i), sizePx, format: FRAME_FORMAT_PNG, view: choice.whole ? FRAME_VIEW_LEVEL : FRAME_VIEW_HUMAN,
    });
    return frames.map(({ image, sizePx: size }, i) => ({
      level: levels[i], image: { format: "png", width: size, height: size, content: image },
    }));
  } finally {
    pool.close();
  }
}
