// The ends of episodes in watched pools, and an enlarged environment.

import assert from "node:assert/strict";
import { test } from "node:test";
import { figure, picture, waitForDrawing, waitForPicture, waitForText, withBrowser } from "../browser.js";
import { COINRUN_1000_ACTIONS, COINRUN_1000_STEPS } from "../playing.js";
import { Pool, withServer } from "../server.js";

const FIRST = "#mosaic li:first-child canvas";
const NONE = 4;
const END = -1;  // ends the episode
const it = withBrowser();
const server = withServer();

// A pool of coinrun in level 1000, which only the test steps, and its page.
async function openPool(poolId, envCount) {
  const pool = await Pool.open(server, ["coinrun"], envCount, { pool_id: poolId, start_level: 1000, num_levels: 1 });
  const step = (...actions) => pool.step(actions);
  const page = await it.open(server.page(`/?pool=pools%2F${poolId}`));
  await page.locator(FIRST).waitFor();
  await waitForDrawing(page, FIRST);
  return { pool, page, step };
}

// Collects what a frame shows whenever its result changes: [outcome, result, picture].
async function recordEnds(page, frame) {
  await page.evaluate((name) => {
    window.ends = [];
    const shown = document.querySelector(name);
    new MutationObserver(() => {
      const end = shown.dataset.ended;
      const text = shown.querySelector(".result")?.textContent;
      if (end && text && window.ends.at(-1)?.[1] !== text) {
        window.ends.push([end, text, shown.querySelector("canvas").toDataURL()]);
      }
    }).observe(shown, { attributes: true, childList: true });
  }, frame);
}

// Enlarges environment 1 of a pool. The steps after it are shown, since its watch has begun.
async function enlarge(page, poolId) {
  await page.click("#mosaic button[title='Environment 1']");
  await waitForText(page.locator("#large-title"), `pools/${poolId}, environment 1`);
  await waitForDrawing(page, "#large-agent");
}

const pictureNow = (page, selector) => page.locator(selector).first().evaluate((canvas) => canvas.toDataURL());

test("the mosaic shows the last frame of an episode with its result, and then the next start", async () => {
  const { pool, page, step } = await openPool("mosaic", 2);
  const start = await picture(page, FIRST);
  await recordEnds(page, "#mosaic li:first-child button");
  for (let i = 0; i < 4; i += 1) {
    await step(7, NONE);
  }
  await waitForPicture(page, FIRST, (now) => now !== start);
  await step(END, NONE);
  await page.waitForFunction(() => window.ends.length === 1);
  const [[outcome, result, last]] = await page.evaluate(() => window.ends);
  assert.deepEqual([outcome, result], ["over", "✕ 0"]);
  await waitForPicture(page, FIRST, (now) => now === start);
  assert.notEqual(last, await pictureNow(page, FIRST));
  await page.locator("#mosaic li:first-child [data-ended]").waitFor({ state: "detached" });
  assert.equal(await page.locator("#mosaic .result").count(), 0);
  await pool.close();
});

test("an enlarged environment shows how an episode ended, with its last frame", async () => {
  const { pool, page, step } = await openPool("enlarged", 1);
  await page.click("#mosaic button");
  await waitForText(page.locator("#large-title"), "pools/enlarged, environment 0");
  await page.waitForFunction(() => document.querySelector("#large-picture").width === 512);
  await waitForDrawing(page, "#large-picture");
  const start = await picture(page, "#large-picture");
  await recordEnds(page, "#large-frame");
  for (const action of COINRUN_1000_ACTIONS) {
    await step(action);
  }
  await page.waitForFunction(() => window.ends.length === 1);
  const [[outcome, result, last]] = await page.evaluate(() => window.ends);
  assert.deepEqual([outcome, result], ["complete", `✓ Level complete: return 10 in ${COINRUN_1000_STEPS} steps`]);
  await waitForPicture(page, "#large-picture", (now) => now === start);
  assert.notEqual(last, await pictureNow(page, "#large-picture"));
  await page.locator("#large-frame .result").waitFor({ state: "detached" });
  await pool.close();
});

test("an enlarged environment shows its newest step beside both views", async () => {
  const { pool, page, step } = await openPool("steps", 2);
  await enlarge(page, "steps");
  const value = (name) => figure(page, "#large-step", name);
  await waitForText(value("Action"), "–");
  await step(NONE, 8);
  await waitForText(value("Action"), "RIGHT+UP");
  assert.deepEqual(await page.locator("#large-keys [data-pressed]").allTextContents(), ["UP", "RIGHT"]);
  assert.equal(await value("Step").textContent(), "1");
  assert.equal(await value("Level seed").textContent(), "1000");
  await step(NONE, END);
  await waitForText(value("Action"), "start");
  assert.equal(await value("Step").textContent(), "0");
  for (const action of COINRUN_1000_ACTIONS) {
    await step(NONE, action);
  }
  await waitForText(value("Return"), /^10$/);
  assert.equal(await value("Reward").textContent(), "+10");
  await waitForText(value("Return"), /^0$/);
  const [human, agent] = await page.locator("#large canvas").evaluateAll((all) => all.map(({ width }) => width));
  assert.deepEqual([human, agent], [512, 64]);
  await pool.close();
});

test("values that the learner sends are drawn as a line and as bars", async () => {
  const { pool, page } = await openPool("annotated", 2);
  await enlarge(page, "annotated");
  assert(await page.locator("#large-annotations").isHidden());
  const line = page.locator(".annotation", { has: page.locator("h3", { hasText: /^value/ }) });
  const equal = Array(15).fill(0.05);
  const unequal = equal.map((probability, action) => (action === 7 ? 0.3 : probability));
  for (const value of [0.1, 0.2, 0.3, 0.4, 0.5]) {
    const annotations = { value: [9, value], action_probabilities: [equal, unequal] };
    await pool.step([NONE, 7], { annotations });
    await waitForText(line.locator(".number").first(), String(value));
  }
  await waitForText(line, "0.1 to 0.5");
  assert.match(await line.locator("path").first().getAttribute("d"), /^M\d+ [\d.]+L\d+/);
  const bars = page.locator(".annotation", { has: page.locator("h3", { hasText: "action_probabilities" }) });
  assert.equal(await bars.locator("li").count(), 15);
  assert.equal(await bars.locator("li").nth(7).textContent(), "RIGHT0.3");
  assert.equal(await bars.locator("li").nth(0).textContent(), "LEFT+DOWN0.05");
  await waitForText(page.locator("#large-step"), "RIGHT");
  await pool.close();
});

test("a saliency map is drawn over the agent's view of its step", async () => {
  const { pool, page } = await openPool("salient", 1);
  await page.click("#mosaic button");
  await waitForDrawing(page, "#large-agent");
  const overlay = page.locator("#large-saliency");
  assert(await overlay.isHidden());
  const map = Array(64 * 64).fill(0);
  map[10 * 64 + 20] = 2;
  map[11 * 64 + 21] = -1;
  await pool.step([7], { annotations: { saliency: [map] } });
  await overlay.waitFor();
  const alphas = await overlay.evaluate((canvas) => {
    const { data } = canvas.getContext("2d").getImageData(0, 0, 64, 64);
    return [...data].flatMap((value, i) => (i % 4 === 3 && value > 0 ? [[(i - 3) / 4, value]] : []));
  });
  assert.deepEqual(alphas, [[10 * 64 + 20, 200], [11 * 64 + 21, 100]]);
  const [over, under] = await Promise.all(["#large-saliency", "#large-agent"].map((name) => page.locator(name).boundingBox()));
  assert.deepEqual(over, under);
  assert(await page.locator("#large-annotations").isHidden());
  await overlay.hover();
  assert.equal(await overlay.evaluate((canvas) => getComputedStyle(canvas).opacity), "0");
  await pool.step([7]);
  await overlay.waitFor({ state: "hidden" });
  await pool.close();
});
