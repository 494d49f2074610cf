// Pages over a line with a long latency: requests are sent before earlier ones are answered.

import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { figure, waitForText, withBrowser } from "../browser.js";
import { COINRUN_1000, COINRUN_1000_PATH, COINRUN_1000_STEPS, playKeys } from "../playing.js";
import { Server } from "../server.js";
import { SlowLine } from "../slow_line.js";

const ONE_WAY_MS = 75;

const it = withBrowser();
let server;
let line;
before(async () => {
  server = await Server.start();
  line = await SlowLine.open(server.web, ONE_WAY_MS);
});
after(async () => {
  line.close();
  assert.equal(await server.stop(), 0);
});

// The JSON of a text or binary message.
function headerOf(payload) {
  return JSON.parse(typeof payload === "string" ? payload : payload.subarray(4, 4 + payload.readUInt32LE(0)).toString());
}

// Opens a page over the line. `most(method)` is the largest number of unanswered requests of this method so far; for a method of
// replays, the smallest of these numbers of all replays.
async function openFar(path) {
  const page = await it.open("about:blank");
  const unanswered = new Map();  // id -> method and replay
  const largest = new Map();
  page.on("websocket", (socket) => {
    socket.on("framesent", ({ payload }) => {
      const { id, method, replay = "" } = headerOf(payload);
      const kind = `${method} ${replay}`;
      unanswered.set(id, kind);
      const now = [...unanswered.values()].filter((one) => one === kind).length;
      largest.set(kind, Math.max(largest.get(kind) ?? 0, now));
    });
    socket.on("framereceived", ({ payload }) => unanswered.delete(headerOf(payload).id));
  });
  await page.goto(`${line.web}${path}`);
  const most = (method) => {
    const counts = [...largest].filter(([kind]) => kind.startsWith(`${method} `)).map(([, count]) => count);
    assert(counts.length > 0, `${method} was never requested`);
    return Math.min(...counts);
  };
  return { page, most };
}

test("play sends steps ahead, and none of them reaches the next episode", async () => {
  const { page, most } = await openFar("/play?game=bigfish&mode=easy&level=7");
  await waitForText(page.locator("#message"), "Press an arrow key to begin.");
  await page.keyboard.press("ArrowLeft");
  await waitForText(page.locator("#message"), "Episode over");
  assert(most("play.step") >= 3, `${most("play.step")} steps were in flight`);
  const steps = await figure(page, "#figures", "Step").textContent();
  await page.click("#replay");
  await waitForText(figure(page, "#figures", "Step"), `0 of ${steps}`);
  assert.equal(await page.locator("#notices .bad").count(), 0);
});

test("running replays side by side request rows ahead, and the first shows each of them", async () => {
  const { page: play } = await openFar(COINRUN_1000_PATH);
  await playKeys(play, COINRUN_1000);
  const [trace] = await Promise.all([play.waitForEvent("download"), play.click("#save")]);
  const { page, most } = await openFar("/replay");
  await page.setInputFiles("#file", await trace.path());
  await waitForText(figure(page, "#figures", "Step"), `0 of ${COINRUN_1000_STEPS}`);
  await page.click("#compare summary");
  await page.setInputFiles("#other-file", await trace.path());
  await waitForText(page.locator("#difference"), "No difference");
  await page.evaluate(() => {
    window.shown = new Set();
    const canvas = document.querySelector("#human");
    new MutationObserver(() => window.shown.add(canvas.getAttribute("aria-label"))).observe(canvas, { attributes: true });
  });
  await page.click("#run");
  await waitForText(figure(page, "#figures", "Step"), `${COINRUN_1000_STEPS} of ${COINRUN_1000_STEPS}`);
  assert(most("replay.seek") >= 3, `${most("replay.seek")} rows were in flight`);
  assert.equal(await page.evaluate(() => window.shown.size), COINRUN_1000_STEPS);
  await waitForText(page.locator("#other-name"), `step ${COINRUN_1000_STEPS} of ${COINRUN_1000_STEPS}`);
});
