// Decodes ENCODING_DELTA_ZSTD (proto/procgen/v1/pools.proto): zstd frames of differences to the previous images of a stream.

import { decompress } from "../vendor/fzstd.js";

export class DeltaDecoder {
  #images = new Map();  // key -> bytes of the last image

  // Returns the images of a message in the order of `keys`, each of which names the image that the difference belongs to.
  decode(encoded, keys) {
    const differences = decompress(encoded);
    const size = differences.length / keys.length;
    return keys.map((key, i) => {
      const image = differences.subarray(i * size, (i + 1) * size);
      const before = this.#images.get(key);
      if (before) {
        for (let at = 0; at < size; at += 1) {
          image[at] += before[at];  // modulo 256
        }
      }
      this.#images.set(key, image);
      return image;
    });
  }
}
