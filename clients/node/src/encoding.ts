// Decodes ENCODING_DELTA_ZSTD. The comment of Encoding in procgen/v1/pools.proto defines the bytes.

import { DataLossError, FailedPreconditionError, InvalidArgumentError } from "./errors.js";
import { frameContent } from "./frame_content.js";
import { Color, Encoding, Layout, type Pool } from "./generated/procgen/v1/pools_pb.js";

const side = 8; // Side of a block, in rows and pixels.
const sizePxDefault = 64; // Side of a frame.

// Returns the decoder for a pool's observations; undefined if they are not encoded.
export function decoderFor(pool: Pool): ObservationDecoder | undefined {
  const encoding = pool.spec!.encoding;
  return encoding === Encoding.RAW || encoding === Encoding.UNSPECIFIED ? undefined : new ObservationDecoder(pool);
}

// Decodes the observations of a pool. They must be decoded once each, in the order of sequence
// numbers, without gaps. The decoder keeps the last observation of each environment, and is
// unchanged after an error.
export class ObservationDecoder {
  readonly #rows: number;
  readonly #columns: number;
  readonly #pixelBytes: number;
  readonly #stack: number;
  readonly #ages: Uint8Array; // The next age of each environment; 0: only a key frame may follow.
  readonly #shown: Uint8Array; // The last observation of each environment, [N * F].
  readonly #basis: Uint8Array; // Scratch: the observation that a delta refers to, [F].

  constructor(pool: Pool) {
    const spec = pool.spec!;
    const format = spec.observationFormat;
    if (spec.encoding !== Encoding.DELTA_ZSTD) {
      throw new InvalidArgumentError(`encoding is ${spec.encoding}, allowed: DELTA_ZSTD`);
    }
    const channels = format?.color === Color.GRAYSCALE ? 1 : 3;
    const isPlanes = format?.layout === Layout.CHW;
    this.#stack = Math.max(format?.frameStack ?? 1, 1);
    this.#columns = format?.sizePx || sizePxDefault;
    this.#rows = this.#columns * this.#stack * (isPlanes ? channels : 1);
    this.#pixelBytes = isPlanes ? 1 : channels;
    this.#ages = new Uint8Array(spec.envCount);
    this.#basis = new Uint8Array(this.#rows * this.#columns * this.#pixelBytes);
    this.#shown = new Uint8Array(spec.envCount * this.#basis.length);
  }

  // Decodes the observations of the environments [first, first + count), uint8 [count * F]. Throws
  // InvalidArgumentError: environments out of range. DataLossError: malformed bytes.
  // FailedPreconditionError: a gap, earlier observations are missing or these were decoded before.
  decode(first: number, count: number, encoded: Uint8Array): Uint8Array {
    if (first < 0 || count < 1 || first + count > this.#ages.length) {
      throw new InvalidArgumentError(`${count} environments from ${first}, the pool has ${this.#ages.length}`);
    }
    const content = this.#read(first, count, frameContent(encoded, this.#contentBytesMax(count)));
    const bytes = this.#basis.length;
    const observations = new Uint8Array(count * bytes);
    for (let i = 0; i < count; i += 1) {
      const observation = observations.subarray(i * bytes, (i + 1) * bytes);
      const shown = this.#shown.subarray((first + i) * bytes, (first + i + 1) * bytes);
      const age = content.ages[i]!;
      this.#writeBasis(shown, age, content.advances[i] ?? 0);
      observation.set(this.#basis);
      for (let block = 0; block < this.#blockCount; block += 1) {
        if (content.isChanged(i, block)) {
          this.#decodeBlock(block, content, observation);
        }
      }
      shown.set(observation);
      this.#ages[first + i] = age === 255 ? 1 : age + 1;
    }
    return observations;
  }

  get #blockColumns(): number {
    return Math.ceil(this.#columns / side);
  }

  get #blockCount(): number {
    return Math.ceil(this.#rows / side) * this.#blockColumns;
  }

  #contentBytesMax(count: number): number {
    const numbers = 2 + Math.ceil(this.#blockCount / 8) + this.#blockCount * (3 + side);
    return count * (numbers + this.#basis.length);
  }

  #read(first: number, count: number, bytes: Uint8Array): Content {
    const content = new Content(bytes, count, this.#stack, this.#blockCount, this.#pixelBytes);
    for (let i = 0; i < count; i += 1) {
      const age = content.ages[i]!;
      const expected = this.#ages[first + i]!;
      if (age !== 0 && age !== expected) {
        throw new FailedPreconditionError(
          `encoded observations: environment ${first + i} has age ${age}, expected: ${expected} or 0; ` +
            "answers are missing or came twice",
        );
      }
      const advance = content.advances[i] ?? 0;
      if (advance >= this.#stack || (age === 0 && advance !== 0)) {
        throw damaged(`a stack of ${this.#stack} moves by ${advance}`);
      }
    }
    this.#checkInside(content, count);
    return content;
  }

  // Checks that nothing outside the plane is patched; blocks in the last row and column may be
  // smaller.
  #checkInside(content: Content, count: number): void {
    let changed = 0;
    let patched = 0;
    for (let i = 0; i < count; i += 1) {
      for (let block = 0; block < this.#blockCount; block += 1) {
        if (!content.isChanged(i, block)) {
          continue;
        }
        const { height, width } = this.#placeOf(block);
        const rows = content.patchedRows[changed++]!;
        if (rows >> height !== 0) {
          throw damaged("a row outside the observation is patched");
        }
        for (let row = 0; row < bitCount(rows); row += 1) {
          const mask = content.masks[patched++]!;
          if (mask === 0 || mask >> width !== 0) {
            throw damaged("a patched row has no patched pixel, or one outside the observation");
          }
        }
      }
    }
  }

  #placeOf(block: number): { row: number; column: number; height: number; width: number } {
    const row = Math.floor(block / this.#blockColumns) * side;
    const column = (block % this.#blockColumns) * side;
    return { row, column, height: Math.min(side, this.#rows - row), width: Math.min(side, this.#columns - column) };
  }

  #writeBasis(shown: Uint8Array, age: number, advance: number): void {
    if (age === 0) {
      this.#basis.fill(0);
      return;
    }
    const frameBytes = this.#basis.length / this.#stack;
    for (let place = 0; place < this.#stack; place += 1) {
      const from = Math.min(place + advance, this.#stack - 1) * frameBytes;
      this.#basis.set(shown.subarray(from, from + frameBytes), place * frameBytes);
    }
  }

  #decodeBlock(block: number, content: Content, observation: Uint8Array): void {
    const { row, column, height, width } = this.#placeOf(block);
    const { down, right, rows } = content.nextBlock();
    const pixelBytes = this.#pixelBytes;
    const rowBytes = this.#columns * pixelBytes;
    for (let y = 0; y < height; y += 1) {
      const from = clamp(row + y + down, this.#rows) * rowBytes;
      const to = (row + y) * rowBytes + column * pixelBytes;
      for (let x = 0; x < width; x += 1) {
        const pixel = from + clamp(column + x + right, this.#columns) * pixelBytes;
        for (let byte = 0; byte < pixelBytes; byte += 1) {
          observation[to + x * pixelBytes + byte] = this.#basis[pixel + byte]!;
        }
      }
      if ((rows >> y) & 1) {
        content.patchRow(observation, to);
      }
    }
  }
}

// The tables of a zstd frame's content, and the read position in those of the blocks.
class Content {
  readonly ages: Uint8Array;
  readonly advances: Uint8Array;
  readonly patchedRows: Uint8Array;
  readonly masks: Uint8Array;
  readonly #changed: Uint8Array;
  readonly #mapBytes: number;
  readonly #down: Int8Array;
  readonly #right: Int8Array;
  readonly #values: Uint8Array;
  readonly #pixelBytes: number;
  #block = 0;
  #mask = 0;
  #value = 0;

  constructor(bytes: Uint8Array, count: number, stack: number, blockCount: number, pixelBytes: number) {
    let at = 0;
    const take = (size: number) => {
      if (size > bytes.length - at) {
        throw damaged("truncated within a table");
      }
      at += size;
      return bytes.subarray(at - size, at);
    };
    this.#pixelBytes = pixelBytes;
    this.#mapBytes = Math.ceil(blockCount / 8);
    this.ages = take(count);
    this.advances = take(stack > 1 ? count : 0);
    this.#changed = take(count * this.#mapBytes);
    const lastBits = blockCount - (this.#mapBytes - 1) * 8;
    for (let i = this.#mapBytes - 1; i < this.#changed.length; i += this.#mapBytes) {
      if (this.#changed[i]! >> lastBits !== 0) {
        throw damaged("a block outside the observation changes");
      }
    }
    const blocks = bitCountOf(this.#changed);
    this.#down = signed(take(blocks));
    this.#right = signed(take(blocks));
    this.patchedRows = take(blocks);
    this.masks = take(bitCountOf(this.patchedRows));
    this.#values = take(bitCountOf(this.masks) * pixelBytes);
    if (at !== bytes.length) {
      throw damaged(`${bytes.length - at} bytes too many`);
    }
  }

  isChanged(row: number, block: number): boolean {
    return ((this.#changed[row * this.#mapBytes + (block >> 3)]! >> (block & 7)) & 1) !== 0;
  }

  nextBlock(): { down: number; right: number; rows: number } {
    const block = this.#block++;
    return { down: this.#down[block]!, right: this.#right[block]!, rows: this.patchedRows[block]! };
  }

  // Writes the next values at each set bit of the next mask, in a row of a block that starts at
  // `to`.
  patchRow(observation: Uint8Array, to: number): void {
    for (let mask = this.masks[this.#mask++]!, pixel = to; mask !== 0; mask >>= 1, pixel += this.#pixelBytes) {
      if (mask & 1) {
        for (let byte = 0; byte < this.#pixelBytes; byte += 1) {
          observation[pixel + byte] = this.#values[this.#value++]!;
        }
      }
    }
  }
}

function damaged(what: string): DataLossError {
  return new DataLossError(`encoded observations: ${what}`);
}

function signed(bytes: Uint8Array): Int8Array {
  return new Int8Array(bytes.buffer, bytes.byteOffset, bytes.length);
}

function clamp(at: number, size: number): number {
  return at < 0 ? 0 : at < size ? at : size - 1;
}

function bitCount(byte: number): number {
  let count = 0;
  for (let bits = byte; bits !== 0; bits &= bits - 1) {
    count += 1;
  }
  return count;
}

function bitCountOf(bytes: Uint8Array): number {
  return bytes.reduce((sum, byte) => sum + bitCount(byte), 0);
}
