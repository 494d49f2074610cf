// Plays the replay in the document: images, as differences, and what happened at each.

const FRAMES_PER_SECOND = 15;

// { title, about, size, count, images: base64 of deflated differences, texts: by frame, values: [{ name, texts: by frame }] }
const replay = JSON.parse(document.getElementById("replay").textContent);

function add(name, attributes = {}, text = "") {
  const made = /** @type {any} */ (document.createElement(name));
  Object.entries(attributes).forEach(([key, value]) => made.setAttribute(key, value));
  made.textContent = text;
  document.body.append(made);
  return made;
}

// All images, one after the other, 3 bytes per pixel.
async function decode() {
  const bytes = Uint8Array.from(atob(replay.images), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  const pixels = new Uint8Array(await new Response(stream).arrayBuffer());
  const imageBytes = replay.size * replay.size * 3;
  for (let at = imageBytes; at < pixels.length; at += 1) {
    pixels[at] += pixels[at - imageBytes];  // modulo 256
  }
  return pixels;
}

async function play() {
  add("h1", {}, replay.title);
  add("p", {}, replay.about);
  const canvas = add("canvas", { width: replay.size, height: replay.size, role: "img" });
  const slider = add("input", { type: "range", min: 0, max: replay.count - 1, value: 0, "aria-label": "Frame" });
  const button = add("button", { type: "button" }, "Play");
  const text = add("p", { role: "status" });
  const values = replay.values.map(({ name, texts }) => ({ line: add("p"), name, texts }));
  const pixels = await decode();
  const image = new ImageData(replay.size, replay.size);
  const show = (frame) => {
    const start = frame * replay.size * replay.size * 3;
    for (let pixel = 0; pixel < replay.size * replay.size; pixel += 1) {
      image.data.set(pixels.subarray(start + pixel * 3, start + pixel * 3 + 3), pixel * 4);
      image.data[pixel * 4 + 3] = 255;
    }
    canvas.getContext("2d").putImageData(image, 0, 0);
    canvas.setAttribute("aria-label", replay.texts[frame]);
    text.textContent = replay.texts[frame];
    values.forEach(({ line, name, texts }) => { line.textContent = `${name} ${texts[frame]}`; });
    slider.value = frame;
  };
  let timer = null;
  const run = (isRunning) => {
    clearInterval(timer);
    timer = isRunning ? setInterval(() => {
      if (slider.valueAsNumber + 1 < replay.count) {
        show(slider.valueAsNumber + 1);
      } else {
        run(false);
      }
    }, 1000 / FRAMES_PER_SECOND) : null;
    button.textContent = isRunning ? "Pause" : "Play";
  };
  button.addEventListener("click", () => {
    if (timer === null && slider.valueAsNumber === replay.count - 1) {
      show(0);
    }
    run(timer === null);
  });
  slider.addEventListener("input", () => {
    run(false);
    show(slider.valueAsNumber);
  });
  show(0);
}

play();
