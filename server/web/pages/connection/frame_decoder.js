// Decodes the frames of a watch. A part of the format "deflate" is the difference to the previous frame of its environment: deflate
// blocks with that frame as their dictionary. Browsers take no dictionary, but a stored block that precedes them does the same.

const STORED_HEADER_BYTES = 5;
const LAST_BLOCK = Uint8Array.of(3, 0);  // empty, and marked as the last one

export class FrameDecoder {
  #frames = new Map();  // environment -> pixels of its last frame
  #last = Promise.resolve();

  // Resolves to the parts, those of the format "deflate" as "rgb". Messages are decoded in order.
  decode(parts) {
    this.#last = this.#last.then(() => this.#decode(parts));
    return this.#last;
  }

  async #decode(parts) {
    const changed = parts.filter(({ format, bytes }) => format === "deflate" && bytes > 0);
    if (changed.length > 0) {
      const blocks = changed.flatMap(({ environment, content }) => [...storedBlock(this.#frames.get(environment)), content]);
      const pixels = await inflate([...blocks, LAST_BLOCK]);
      let offset = 0;
      for (const { environment, width, height } of changed) {
        offset += this.#frames.get(environment)?.length ?? 0;
        this.#frames.set(environment, pixels.subarray(offset, offset + width * height * 3));
        offset += width * height * 3;
      }
    }
    return parts.map((part) => part.format !== "deflate" ? part
      : { ...part, format: "rgb", content: this.#frames.get(part.environment) });
  }
}

// A frame as a block that is not compressed; nothing before the first frame.
function storedBlock(frame) {
  if (!frame) {
    return [];
  }
  const header = new DataView(new ArrayBuffer(STORED_HEADER_BYTES));
  header.setUint16(1, frame.length, true);
  header.setUint16(3, ~frame.length, true);
  return [new Uint8Array(header.buffer), frame];
}

async function inflate(blocks) {
  const stream = new Blob(blocks).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}
