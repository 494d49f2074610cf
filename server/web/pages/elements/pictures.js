// Draws image parts of messages on canvases.

// Draws a part of the format "rgb" (top row first) or "png" on a canvas, which gets its size. Returns a promise.
export async function drawPart(canvas, part) {
  if (canvas.width !== part.width || canvas.height !== part.height) {
    canvas.width = part.width;
    canvas.height = part.height;
  }
  const context = canvas.getContext("2d", { alpha: false });
  if (part.format === "rgb") {
    context.putImageData(imageOf(part), 0, 0);
    return;
  }
  // Decoded off the main thread; an image that is ready after its successor is dropped.
  const turn = (turns.get(canvas) ?? 0) + 1;
  turns.set(canvas, turn);
  const bitmap = await createImageBitmap(new Blob([part.content], { type: "image/png" }));
  if ((shown.get(canvas) ?? 0) < turn) {
    shown.set(canvas, turn);
    context.drawImage(bitmap, 0, 0);
  }
  bitmap.close();
}

const turns = new WeakMap();  // canvas -> number of images started
const shown = new WeakMap();  // canvas -> number of the image shown

function imageOf({ width, height, content }) {
  const image = new ImageData(width, height);
  const pixels = image.data;
  for (let from = 0, to = 0; from < content.length; from += 3, to += 4) {
    pixels[to] = content[from];
    pixels[to + 1] = content[from + 1];
    pixels[to + 2] = content[from + 2];
    pixels[to + 3] = 255;
  }
  return image;
}

// The part of a message with this name.
export function partOf(message, name) {
  return message.parts.find((part) => part.name === name);
}
