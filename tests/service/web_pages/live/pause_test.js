// A learner is paused by a page, stepped, and resumed.

import assert from "node:assert/strict";
import { before, test } from "node:test";
import { setTimeout as sleep } from "node:timers/promises";
import { figure, waitForDrawing, waitForText, withBrowser } from "../browser.js";
import { Learner, withServer } from "../server.js";

const FIRST = "#mosaic canvas >> nth=0";
const it = withBrowser();
const server = withServer();
let learner;
before(async () => {
  learner = await Learner.start(server, "paused", ["coinrun"], 2);
});

async function openPool() {
  const page = await it.open(server.page("/?pool=pools%2Fpaused"));
  await page.locator(FIRST).waitFor();
  return page;
}

// The number of steps of the learner, once it no longer changes.
async function settledSteps() {
  for (let before = -1; before !== learner.stepCount;) {
    before = learner.stepCount;
    await sleep(300);
  }
  return learner.stepCount;
}

async function waitForSteps(count) {
  while (learner.stepCount < count) {
    await sleep(20);
  }
}

test("a paused learner waits, makes single steps, and continues when it is resumed", async () => {
  const page = await openPool();
  const other = await openPool();
  await page.click("#pool-pause >> text=Pause learner");
  await waitForText(page.locator("#pool-state"), "Paused");
  await waitForText(page.locator("#pools .badge"), "paused");
  await waitForText(other.locator("#pool-pause"), "Paused by another page.");
  assert.equal(await other.locator("#pool-pause >> text=Next step").isVisible(), false);
  const steps = await settledSteps();
  await page.click("#pool-pause >> text=Next step");
  await waitForSteps(steps + 1);
  assert.equal(await settledSteps(), steps + 1);

  // The enlarged view has the same buttons and shows each step.
  await page.click(FIRST);
  await waitForDrawing(page, "#large-agent");
  const length = async () => Number(await figure(page, "#large-step", "Step").textContent());
  await page.click("#large-pause >> text=Next step");
  await page.waitForFunction(() => /\d/.test(document.querySelector("#large-step").textContent));
  const first = await length();
  await page.click("#large-pause >> text=Next step");
  await page.waitForFunction((old) => {
    const terms = [...document.querySelectorAll("#large-step dt")];
    return Number(terms.find((term) => term.textContent === "Step").nextElementSibling.textContent) !== old;
  }, first);
  assert.equal(await length(), first + 1);
  await page.click("#large-pause >> text=Resume learner");
  await waitForText(page.locator("#pool-state"), "running");
  await waitForSteps(steps + 20);
});

test("a pause ends with its page, and when the page opens another pool", async () => {
  const second = await Learner.start(server, "second", ["maze"], 1);
  for (const leave of [(page) => page.close(), (page) => page.click("#pools >> text=pools/second")]) {
    const page = await openPool();
    await page.click("#pool-pause >> text=Pause learner");
    await waitForText(page.locator("#pool-state"), "Paused");
    const steps = await settledSteps();
    await leave(page);
    await waitForSteps(steps + 20);
  }
  await second.stop();
});

test("a forgotten pause ends after ten minutes", async () => {
  const page = await it.open(server.page("/?pool=pools%2Fpaused"), {});
  await page.clock.install();
  await page.reload();
  await page.locator(FIRST).waitFor();
  await page.click("#pool-pause >> text=Pause learner");
  await waitForText(page.locator("#pool-pause"), "the learner waits");
  const steps = await settledSteps();
  await page.clock.fastForward("10:01");
  await waitForText(page.locator("#notices"), "runs again");
  await waitForSteps(steps + 20);
});
