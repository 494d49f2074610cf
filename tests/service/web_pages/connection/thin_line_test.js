// Pages over a line with little bandwidth: frames are small, and figures do not wait for them.

import assert from "node:assert/strict";
import { createHash } from "node:crypto";
import { EventEmitter, once } from "node:events";
import { test } from "node:test";
import { decodeMessages } from "../bridge_messages.js";
import { waitForText, withBrowser } from "../browser.js";
import { COINRUN_1000_PATH } from "../playing.js";
import { Learner, Pool, withServer } from "../server.js";
import { SlowLine } from "../slow_line.js";

const ENV_COUNT = 16;
const FRAMES_PER_SECOND = 15;
const MOSAIC_BYTES_PER_SECOND_MAX = 400_000;
const THIN_BYTES_PER_SECOND = 60_000;

const it = withBrowser();
const server = withServer();

// Opens a page, and collects the messages from the server: { method, message, length, time }.
async function openRecorded(address) {
  const page = await it.open("about:blank");
  const messages = [];
  const arrivals = new EventEmitter();
  await decodeMessages(page, server, {
    onReceived: (message) => {
      messages.push(message);
      arrivals.emit("message");
    },
  });
  await page.goto(address);
  const of = (name) => messages.filter(({ method }) => method === name);
  // Waits until `count` responses of a method have arrived; returns them.
  const responses = async (name, count) => {
    while (of(name).length < count) {
      await once(arrivals, "message");
    }
    return of(name);
  };
  return { page, responses };
}

// The SHA-256 of the pixels of all canvases of the mosaic, without alpha.
async function shownPixels(page) {
  const pixels = await page.locator("#mosaic canvas").evaluateAll((all) => all.flatMap((canvas) =>
    [...canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data].filter((_, i) => i % 4 !== 3)));
  return createHash("sha256").update(Buffer.from(pixels)).digest("hex");
}

test("the mosaic shows the exact observations for less than a seventh of their bytes", async () => {
  const pool = await Pool.open(server, ["coinrun"], ENV_COUNT, { pool_id: "stepped", distribution_mode: "hard" });
  const { page, responses } = await openRecorded(server.page("/?pool=pools/stepped"));
  let observations;
  for (let step = 0; step < 30; step += 1) {
    observations = await pool.step(Array(ENV_COUNT).fill(step % 9));
    await responses("WatchPool", step + 1);
  }
  while (await shownPixels(page) !== observations) {
    // The last frames are on their way.
  }
  const frames = (await responses("WatchPool", 2)).slice(1);
  const mean = frames.reduce((sum, { length }) => sum + length, 0) / frames.length;
  assert(mean * FRAMES_PER_SECOND < MOSAIC_BYTES_PER_SECOND_MAX, `${mean * FRAMES_PER_SECOND} bytes a second`);
  await pool.close();
});

test("figures arrive every second while frames use all of the line", async () => {
  const learner = await Learner.start(server, "watched", ["starpilot"], ENV_COUNT);
  const line = await SlowLine.open(server.web, 0, THIN_BYTES_PER_SECOND);
  const { responses } = await openRecorded(`${line.web}/?pool=pools/watched`);
  await responses("WatchPool", 3);
  const before = (await responses("ListPools", 1)).length;
  const figures = (await responses("ListPools", before + 6)).slice(before);
  const seconds = (figures.at(-1).time - figures[0].time) / 1000 / (figures.length - 1);
  assert(seconds < 2, `figures every ${seconds} s`);
  line.close();
  await learner.stop();
});

test("play asks for a smaller human view if the line is too thin for a large one", async () => {
  const line = await SlowLine.open(server.web, 0, 300_000);
  const { page } = await openRecorded(`${line.web}${COINRUN_1000_PATH}`);
  await waitForText(page.locator("#message"), "Press an arrow key to begin.");
  assert.equal(await page.locator("#human").evaluate((canvas) => canvas.width), 512);
  await page.keyboard.down("ArrowLeft");
  await page.waitForFunction(() => document.querySelector("#human").width < 512);
  await page.keyboard.up("ArrowLeft");
  line.close();
});
