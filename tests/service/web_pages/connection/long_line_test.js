// Pages over a line with a long latency: requests are sent before earlier ones are answered.

import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { decodeMessages } from "../bridge_messages.js";
import { figure, waitForText, withBrowser } from "../browser.js";
import { COINRUN_1000, COINRUN_1000_PATH, COINRUN_1000_STEPS, playKeys } from "../playing.js";
import { withServer } from "../server.js";
import { SlowLine } from "../slow_line.js";

const ONE_WAY_MS = 75;

const it = withBrowser();
const server = withServer();
let line;
before(async () => {
  await server.opened;
  line = await SlowLine.open(server.web, ONE_WAY_MS);
});
after(async () => {
  line.close();
});

// Opens a page over the line. `most()` is the largest number of images of a pool of the page that were requested and not answered; of
// several pools, the smallest of these numbers.
async function openFar(path) {
  const page = await it.open("about:blank");
  const requested = new Map();  // call -> { now, most }
  await decodeMessages(page, server, {
    onSent: ({ call, message }) => {
      if (message.request?.case === "render") {
        const { now = 0, most = 0 } = requested.get(call) ?? {};
        requested.set(call, { now: now + 1, most: Math.max(most, now + 1) });
      }
    },
    onReceived: ({ call, message }) => {
      if (message.response?.case === "frames") {
        requested.get(call).now -= 1;
      }
    },
  });
  await page.goto(`${line.web}${path}`);
  return { page, most: () => Math.min(...[...requested.values()].map(({ most }) => most)) };
}

test("play sends steps ahead, and none of them reaches the next episode", async () => {
  const { page, most } = await openFar("/play?game=bigfish&mode=easy&level=7");
  await waitForText(page.locator("#message"), "Press an arrow key to begin.");
  await page.keyboard.press("ArrowLeft");
  await waitForText(page.locator("#message"), "Episode over");
  assert(most() >= 3, `${most()} steps were in flight`);
  const steps = await figure(page, "#figures", "Step").textContent();
  await page.click("#replay");
  await waitForText(figure(page, "#figures", "Step"), `0 of ${steps}`);
  assert.equal(await page.locator("#verdict").textContent(), "Identical to the recording");
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
  assert(most() >= 3, `${most()} rows were in flight`);
  assert.equal(await page.evaluate(() => window.shown.size), COINRUN_1000_STEPS);
  await waitForText(page.locator("#other-name"), `step ${COINRUN_1000_STEPS} of ${COINRUN_1000_STEPS}`);
});
