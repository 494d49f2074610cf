// Saved images and videos, decoded by the browser.

// The mean difference of an image file (base64) from a canvas, enlarged to the image's size, and the size.
export function differenceFrom(page, canvas, content) {
  return page.evaluate(async ([selector, text]) => {
    const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
    const image = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
    const pixels = (source) => {
      const target = new OffscreenCanvas(image.width, image.height).getContext("2d");
      target.imageSmoothingEnabled = false;
      target.drawImage(source, 0, 0, image.width, image.height);
      return target.getImageData(0, 0, image.width, image.height).data;
    };
    const [got, wanted] = [pixels(image), pixels(document.querySelector(selector))];
    return { size: image.width, difference: got.reduce((sum, value, i) => sum + Math.abs(value - wanted[i]), 0) / got.length };
  }, [canvas, content]);
}

// Decodes a video in a page of its own, without the server's rules. Returns its size, its duration, and its frame at a
// time as PNG.
export async function decode(it, content, timeS) {
  const page = await it.open("about:blank");
  return page.evaluate(async ([text, time]) => {
    const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
    const video = document.createElement("video");
    const loaded = new Promise((resolve, reject) => {
      video.onloadeddata = resolve;
      video.onerror = () => reject(new Error(video.error.message));
    });
    video.src = URL.createObjectURL(new Blob([bytes], { type: "video/mp4" }));
    await loaded;
    // The event "seeked" may come before its frame can be drawn.
    const presented = new Promise((resolve) => {
      const wait = () => video.requestVideoFrameCallback((_, { mediaTime }) => (Math.abs(mediaTime - time) < 0.1 ? resolve() : wait()));
      wait();
    });
    video.currentTime = time;
    await presented;
    const canvas = document.createElement("canvas");
    canvas.width = video.videoWidth;
    canvas.height = video.videoHeight;
    canvas.getContext("2d").drawImage(video, 0, 0);
    const image = canvas.toDataURL("image/png");
    return { width: video.videoWidth, height: video.videoHeight, duration: video.duration, content: image.slice(image.indexOf(",") + 1) };
  }, [content, timeS]);
}
