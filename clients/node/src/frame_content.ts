// The content of one frame of zstd or LZ4, whatever bytes it is. Both libraries are JavaScript, and neither looks at
// checksums: LZ4's is looked at here, zstd's is not.

import { decompress } from "fzstd";
import lz4 from "lz4js";
import xxh32 from "lz4js/xxh32.js";
import { DataLossError } from "./errors.js";
import { Encoding } from "./generated/procgen/v1/pools_pb.js";

export function frameContent(encoding: Encoding, frame: Uint8Array, sizeMax: number): Uint8Array {
  const format = encoding === Encoding.ZSTD_DIFFERENCE ? zstd : lz4Frame;
  const size = format.contentSize(frame);
  if (size === undefined) {
    throw new DataLossError("encoded observations: no frame that tells the size of its content");
  }
  if (size > sizeMax) {
    throw new DataLossError(`encoded observations: content of ${size} bytes, there can be ${sizeMax} at most`);
  }
  let content: Uint8Array;
  try {
    content = format.content(frame, size);
  } catch (error) {
    throw new DataLossError(`encoded observations: not one whole frame: ${(error as Error).message}`, { cause: error });
  }
  if (content.length !== size) {
    throw new DataLossError(`encoded observations: content of ${content.length} bytes, the frame tells ${size}`);
  }
  return content;
}

interface Format {
  // What the frame's header tells; undefined where it tells nothing.
  contentSize(frame: Uint8Array): number | undefined;
  content(frame: Uint8Array, size: number): Uint8Array;
}

// RFC 8878, 3.1.1.
const zstd: Format = {
  contentSize(frame) {
    const headerBytesMax = 18; // A frame may be shorter than the longest header.
    const view = new DataView(new Uint8Array(headerBytesMax).buffer);
    frame.subarray(0, headerBytesMax).forEach((byte, at) => view.setUint8(at, byte));
    if (frame.length < 9 || view.getUint32(0, true) !== 0xfd2fb528) {
      return undefined;
    }
    const descriptor = frame[4]!;
    const isSingleSegment = (descriptor & 0x20) !== 0;
    const dictionaryBytes = [0, 1, 2, 4][descriptor & 3]!;
    const at = (isSingleSegment ? 5 : 6) + dictionaryBytes;
    switch (descriptor >> 6) {
      case 0:
        return isSingleSegment ? view.getUint8(at) : undefined;
      case 1:
        return view.getUint16(at, true) + 256;
      case 2:
        return view.getUint32(at, true);
      default:
        return Number(view.getBigUint64(at, true));
    }
  },
  content: (frame) => decompress(frame),
};

// LZ4 frame format 1.6.
const lz4Frame: Format = {
  contentSize(frame) {
    const view = new DataView(frame.buffer, frame.byteOffset, frame.length);
    const tellsSize = frame.length >= 15 && view.getUint32(0, true) === 0x184d2204 && (frame[4]! & 0x08) !== 0;
    return tellsSize ? Number(view.getBigUint64(6, true)) : undefined;
  },
  content(frame, size) {
    const content = new Uint8Array(size);
    const written = lz4.decompressFrame(frame, content);
    const checksum = new DataView(frame.buffer, frame.byteOffset + frame.length - 4, 4).getUint32(0, true);
    if ((frame[4]! & 0x04) !== 0 && checksum !== xxh32.hash(0, content, 0, size) >>> 0) {
      throw new Error("its checksum is another");
    }
    return written === size ? content : content.subarray(0, Math.min(written, size - 1));
  },
};
