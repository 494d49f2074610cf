// Writes WebM files (https://www.matroska.org/technical/elements.html): one video track, whose frames are encoded already.

const ID = {
  EBML: 0x1A45DFA3, EBMLVersion: 0x4286, EBMLReadVersion: 0x42F7, EBMLMaxIDLength: 0x42F2, EBMLMaxSizeLength: 0x42F3,
  DocType: 0x4282, DocTypeVersion: 0x4287, DocTypeReadVersion: 0x4285,
  Segment: 0x18538067, Info: 0x1549A966, TimestampScale: 0x2AD7B1, Duration: 0x4489, MuxingApp: 0x4D80, WritingApp: 0x5741,
  Tracks: 0x1654AE6B, TrackEntry: 0xAE, TrackNumber: 0xD7, TrackUID: 0x73C5, TrackType: 0x83, CodecID: 0x86,
  Video: 0xE0, PixelWidth: 0xB0, PixelHeight: 0xBA,
  Cluster: 0x1F43B675, Timestamp: 0xE7, SimpleBlock: 0xA3,
};
const TRACK = 1;
const NANOSECONDS_PER_MILLISECOND = 1_000_000;
const CLUSTER_MS = 30_000;  // times in a cluster have 16 bits with a sign

// Bytes of a number, big-endian, as few as it needs.
function integer(value) {
  const bytes = [];
  for (let rest = value; rest > 0 || bytes.length === 0; rest = Math.floor(rest / 256)) {
    bytes.unshift(rest % 256);
  }
  return bytes;
}

function size(value) {
  const bytes = integer(value);
  const lengthBytes = 8;
  return [0x01, ...new Array(lengthBytes - 1 - bytes.length).fill(0), ...bytes];
}

// An element with `content`: numbers are bytes, a text is ASCII, and lists contain elements.
function element(name, ...content) {
  const parts = content.flat().map((part) => (part instanceof Uint8Array ? part : Uint8Array.of(part)));
  const length = parts.reduce((sum, part) => sum + part.length, 0);
  const head = [...integer(ID[name]), ...size(length)];
  const bytes = new Uint8Array(head.length + length);
  bytes.set(head);
  let at = head.length;
  for (const part of parts) {
    bytes.set(part, at);
    at += part.length;
  }
  return bytes;
}

function text(name, value) {
  return element(name, new TextEncoder().encode(value));
}

function real(name, value) {
  const bytes = new Uint8Array(8);
  new DataView(bytes.buffer).setFloat64(0, value);
  return element(name, bytes);
}

function number(name, value) {
  return element(name, integer(value));
}

function header({ codec, width, height, durationMs }) {
  return [
    element("EBML", number("EBMLVersion", 1), number("EBMLReadVersion", 1), number("EBMLMaxIDLength", 4),
      number("EBMLMaxSizeLength", 8), text("DocType", "webm"), number("DocTypeVersion", 4), number("DocTypeReadVersion", 2)),
    element("Info", number("TimestampScale", NANOSECONDS_PER_MILLISECOND), real("Duration", durationMs),
      text("MuxingApp", "Procgen Server"), text("WritingApp", "Procgen Server")),
    element("Tracks", element("TrackEntry", number("TrackNumber", TRACK), number("TrackUID", TRACK), number("TrackType", 1),
      text("CodecID", codec), element("Video", number("PixelWidth", width), number("PixelHeight", height)))),
  ];
}

function cluster(frames) {
  const begin = frames[0].timeMs;
  return element("Cluster", number("Timestamp", begin), ...frames.map(({ timeMs, isKey, bytes }) => {
    const offset = timeMs - begin;
    return element("SimpleBlock", 0x80 | TRACK, offset >> 8, offset & 0xFF, isKey ? 0x80 : 0, bytes);
  }));
}

// Returns a file. `codec`: "V_VP8" or "V_VP9"; `frames`: { timeMs, isKey, bytes }, in order of time, which are integers.
export function webm({ codec, width, height, durationMs, frames }) {
  const clusters = [];
  for (const frame of frames) {
    const last = clusters.at(-1);
    if (last && frame.timeMs - last[0].timeMs < CLUSTER_MS && !frame.isKey) {
      last.push(frame);
    } else {
      clusters.push([frame]);
    }
  }
  const [ebml, info, tracks] = header({ codec, width, height, durationMs });
  return new Blob([ebml, element("Segment", info, tracks, ...clusters.map(cluster))], { type: "video/webm" });
}
