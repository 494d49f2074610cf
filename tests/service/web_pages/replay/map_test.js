// The map of a replay: the whole level and the path of the agent.

import assert from "node:assert/strict";
import { test } from "node:test";
import { figure, picture, waitForPicture, waitForText, withBrowser } from "../browser.js";
import { COINRUN_1000, COINRUN_1000_PATH, COINRUN_1000_STEPS, playKeys } from "../playing.js";
import { withServer } from "../server.js";

const MAP = "#map-picture";
const it = withBrowser();
const server = withServer();

// The number of pixels of the path so far and of the agent's place.
function pathPixels(page) {
  return page.locator(MAP).evaluate((canvas) => {
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    return data.filter((_, i) => i % 4 === 0 && data[i] === 255 && data[i + 1] === 216 && data[i + 2] === 61).length;
  });
}

async function seek(page, number) {
  const before = await picture(page, MAP);
  await page.locator("#row").fill(String(number));
  await waitForText(figure(page, "#figures", "Step"), new RegExp(`^${number} of `));
  await waitForPicture(page, MAP, (shown) => shown !== before);
}

test("a map shows the level and the path, which grows with the steps", async () => {
  const page = await it.open(server.page(COINRUN_1000_PATH));
  await waitForText(figure(page, "#figures", "Step"), /^0$/);
  await playKeys(page, COINRUN_1000);
  await page.locator(`#human[aria-label*="step ${COINRUN_1000_STEPS}, score 10"]`).waitFor();
  await page.click("#replay");
  await page.waitForURL("**/replay");
  await waitForText(figure(page, "#figures", "Step"), /^0 of/);
  assert.equal(await page.locator(MAP).isVisible(), false);
  await page.click("#map summary");
  await waitForText(page.locator("#map-about"), "Level 1000");
  const atStart = await pathPixels(page);
  assert(atStart > 0, "the agent's place is marked");
  await seek(page, Math.floor(COINRUN_1000_STEPS / 2));
  const halfway = await pathPixels(page);
  assert(halfway > atStart + 50, `${halfway} pixels of the path, ${atStart} at the start`);
  // The end of the episode shows this level, not the next.
  await seek(page, COINRUN_1000_STEPS);
  assert(await pathPixels(page) > halfway + 50);
  await seek(page, 0);
  assert.equal(await pathPixels(page), atStart);
});
