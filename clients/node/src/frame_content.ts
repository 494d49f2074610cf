// Decompresses one zstd frame (RFC 8878) from an untrusted source. The library, in JavaScript, does
// not verify checksums.

import { decompress } from "fzstd";
import { DataLossError } from "./errors.js";

// Throws DataLossError: not a complete frame, a frame without content size, or content above
// `sizeMax` bytes.
export function frameContent(frame: Uint8Array, sizeMax: number): Uint8Array {
  const size = contentSize(frame);
  if (size === undefined) {
    throw new DataLossError("encoded observations: no zstd frame with a content size");
  }
  if (size > sizeMax) {
    throw new DataLossError(`encoded observations: content of ${size} bytes, expected: at most ${sizeMax}`);
  }
  let content: Uint8Array;
  try {
    content = decompress(frame);
  } catch (error) {
    throw new DataLossError(`encoded observations: not one complete zstd frame: ${(error as Error).message}`, {
      cause: error,
    });
  }
  if (content.length !== size) {
    throw new DataLossError(`encoded observations: content of ${content.length} bytes, expected: ${size}`);
  }
  return content;
}

// Returns the content size in the frame's header (RFC 8878, 3.1.1); undefined if it has none.
function contentSize(frame: Uint8Array): number | undefined {
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
}
