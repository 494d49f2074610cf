// A replay as one HTML file, which needs no server: its images as differences, and a player.

const PLAYER = "/assets/standalone/player.js";
const STYLE = "/assets/standalone/player.css";

async function textOf(address) {
  return (await fetch(address)).text();
}

// The differences of images of equal length to the ones before, deflated, in base64.
async function pack(images) {
  const differences = images.map((image, i) => (i === 0 ? image : image.map((value, at) => value - images[i - 1][at])));
  const stream = new Blob(differences).stream().pipeThrough(new CompressionStream("deflate-raw"));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  return btoa(bytes.reduce((text, byte) => text + String.fromCharCode(byte), ""));
}

// A text as the content of an element, without a tag that would end it.
function escaped(text) {
  return text.replaceAll("<", "\\u003c");
}

// The file as a Blob. `replay`: { title, about, size, images: pixels of each frame, 3 bytes each, texts: by frame, values: [{ name, texts }] }.
export async function pageFile({ images, ...replay }) {
  const [player, style] = await Promise.all([textOf(PLAYER), textOf(STYLE)]);
  const data = escaped(JSON.stringify({ ...replay, count: images.length, images: await pack(images) }));
  return new Blob([
    '<!doctype html>\n<html lang="en">\n<meta charset="utf-8">\n<meta name="viewport" content="width=device-width, initial-scale=1">\n',
    `<title>Replay</title>\n<style>\n${style}</style>\n<body>\n<script type="application/json" id="replay">${data}</script>\n`,
    `<script type="module">\n${player}</script>\n`,
  ], { type: "text/html" });
}
