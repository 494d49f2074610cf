// Binary messages: the length of a JSON header (uint32, little-endian), the header, and the bytes of its parts, one after
// the other.

const LENGTH_BYTES = 4;

// Encodes a header and the bytes of the parts that it describes.
export function encode(header, parts = []) {
  const text = new TextEncoder().encode(JSON.stringify(header));
  const size = parts.reduce((sum, part) => sum + part.length, LENGTH_BYTES + text.length);
  const message = new Uint8Array(size);
  new DataView(message.buffer).setUint32(0, text.length, true);
  message.set(text, LENGTH_BYTES);
  let offset = LENGTH_BYTES + text.length;
  for (const part of parts) {
    message.set(part, offset);
    offset += part.length;
  }
  return message;
}

// Decodes a message. Returns its header, in which each part has its bytes as `content` (a view, not a copy).
export function decode(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, LENGTH_BYTES, length)));
  let offset = LENGTH_BYTES + length;
  for (const part of header.parts ?? []) {
    part.content = new Uint8Array(buffer, offset, part.bytes);
    offset += part.bytes;
  }
  return header;
}
