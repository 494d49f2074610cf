// Layout on small screens and touch screens: what belongs together is visible together.

import assert from "node:assert/strict";
import { test } from "node:test";
import { figure, waitForText, withBrowser } from "./browser.js";
import { COINRUN_1000, COINRUN_1000_PATH, playKeys } from "./playing.js";
import { withServer } from "./server.js";

const PHONE = { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true };
const SIDEWAYS = { viewport: { width: 844, height: 390 }, hasTouch: true, isMobile: true };

const it = withBrowser();
const server = withServer();

async function checkVisible(page, ...selectors) {
  const { width, height } = page.viewportSize();
  for (const selector of selectors) {
    const box = await page.locator(selector).boundingBox();
    assert(box && box.x >= 0 && box.y >= 0 && box.x + box.width <= width && box.y + box.height <= height,
      `${selector} is at ${JSON.stringify(box)} of ${width} x ${height}`);
  }
}

async function openPlay(query, options) {
  const page = await it.open(server.page(`/play?${query}`), options);
  await waitForText(page.locator("#message"), "to begin.");
  return page;
}

test("the start message does not cover the picture", async () => {
  for (const options of [{}, PHONE, SIDEWAYS]) {
    const page = await openPlay("game=leaper&mode=easy&level=1", options);
    const [message, picture] = await Promise.all(["#message", "#human"].map((name) => page.locator(name).boundingBox()));
    const isApart = message.y >= picture.y + picture.height || message.y + message.height <= picture.y
      || message.x >= picture.x + picture.width || message.x + message.width <= picture.x;
    assert(isApart, `message ${JSON.stringify(message)}, picture ${JSON.stringify(picture)}`);
  }
});

test("on phones of any size the picture and the touch keys are visible together", async () => {
  for (const [width, height] of [[320, 568], [360, 640], [375, 667], [568, 320]]) {
    const page = await openPlay("game=ninja&mode=easy&level=1", { viewport: { width, height }, hasTouch: true, isMobile: true });
    await checkVisible(page, "#human", ".cross", ".letters");
    const { width: side } = await page.locator("#human").boundingBox();
    assert(side >= 0.4 * Math.min(width, height), `the picture has ${side} pixels of ${width} x ${height}`);
  }
});

test("touch screens have a button for each effect, which says what it does, and are not told to press keys", async () => {
  const maze = await openPlay("game=maze&mode=easy&level=1", PHONE);
  assert.match(await maze.locator("#message").textContent(), /Touch an arrow below to begin\.$/);
  assert.equal(await maze.locator(".letters button:visible").count(), 0);
  const starpilot = await openPlay("game=starpilot&mode=easy&level=1", PHONE);
  const letters = starpilot.locator(".letters button:visible");
  assert.deepEqual(await letters.allTextContents(), ["D Fires a bullet forwards", "A Fires a bullet backwards"]);
});

test("on a phone a replay and its controls are visible together, upright and sideways", async () => {
  for (const options of [PHONE, SIDEWAYS]) {
    const page = await it.open(server.page(COINRUN_1000_PATH), options);
    await playKeys(page, COINRUN_1000.slice(0, 2));
    await page.click("#replay");
    await waitForText(figure(page, "#figures", "Step"), "0 of 3");
    await checkVisible(page, "#human", "#row", "#run", "#forward", "#last");
  }
});
