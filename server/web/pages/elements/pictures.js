// Draws images on canvases. An image is { format, width, height, content }.

// Draws an image of the format "rgb" (top row first) or "png" on a canvas, which gets its size. Returns a promise.
export async function drawImage(canvas, image) {
  if (canvas.width !== image.width || canvas.height !== image.height) {
    canvas.width = image.width;
    canvas.height = image.height;
  }
  const context = canvas.getContext("2d", { alpha: false });
  if (image.format === "rgb") {
    context.putImageData(pixelsOf(image), 0, 0);
    return;
  }
  // Decoded off the main thread; an image that is ready after its successor is dropped.
  const turn = (turns.get(canvas) ?? 0) + 1;
  turns.set(canvas, turn);
  const bitmap = await createImageBitmap(new Blob([image.content], { type: "image/png" }));
  if ((shown.get(canvas) ?? 0) < turn) {
    shown.set(canvas, turn);
    context.drawImage(bitmap, 0, 0);
  }
  bitmap.close();
}

const turns = new WeakMap();  // canvas -> number of images started
const shown = new WeakMap();  // canvas -> number of the image shown

function pixelsOf({ width, height, content }) {
  const drawing = new ImageData(width, height);
  const pixels = drawing.data;
  for (let from = 0, to = 0; from < content.length; from += 3, to += 4) {
    pixels[to] = content[from];
    pixels[to + 1] = content[from + 1];
    pixels[to + 2] = content[from + 2];
    pixels[to + 3] = 255;
  }
  return drawing;
}
