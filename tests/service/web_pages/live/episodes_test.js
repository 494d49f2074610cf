// The episodes of a pool: table, charts, replays.

import assert from "node:assert/strict";
import { before, test } from "node:test";
import { figure, waitForText, withBrowser } from "../browser.js";
import { Pool, Server, withServer } from "../server.js";

const ENV_COUNT = 16;
const STEPS = 600;
const ROWS = "#episode-rows tr";
const it = withBrowser();
const server = withServer();
before(async () => {
  await playStarpilot("all", {});
  await playStarpilot("train", { start_level: 5, num_levels: 3 });
});

// Steps a pool, the same way each time, so that the page shows what has ended and no more.
async function playStarpilot(poolId, options) {
  const pool = await Pool.open(server, ["starpilot"], ENV_COUNT, { pool_id: poolId, ...options });
  for (let step = 0; step < STEPS; step += 1) {
    await pool.step(Array.from({ length: ENV_COUNT }, (_, i) => (step % 3 ? 9 : (Math.floor(step / 20) * 7 + i * 5) % 9)));
  }
}

// Opens the episodes of a pool that has ended at least `count`.
async function openEpisodes(pool, count) {
  const page = await it.open(server.page(`/?pool=pools%2F${pool}`));
  await page.waitForFunction(([rows, wanted]) => document.querySelectorAll(rows).length >= wanted, [ROWS, count]);
  // The rows stand still while the focus is in them.
  await page.locator(`${ROWS} button`).first().focus();
  return page;
}

// The texts of a column, from the top.
async function column(page, title) {
  const titles = await page.locator("#episode-columns th").allInnerTexts();
  const index = titles.findIndex((text) => text.replace(/\W+$/, "") === title);
  return page.locator(`${ROWS} td:nth-child(${index + 1})`).allTextContents();
}

test("the table is sorted by any column, so that the best and the worst episode are on top", async () => {
  const page = await openEpisodes("all", 12);
  await page.click("#episode-columns button:has-text('Return')");
  const falling = (await column(page, "Return")).map(Number);
  assert(falling.length >= 12);
  assert.deepEqual(falling, [...falling].sort((a, b) => b - a));
  assert.equal(await page.getAttribute("#episode-columns th:has-text('Return')", "aria-sort"), "descending");
  await page.keyboard.press("Enter");
  const rising = (await column(page, "Return")).map(Number);
  assert.deepEqual(rising, [...rising].sort((a, b) => a - b));
  await page.click("#episode-columns button:has-text('Length')");
  const lengths = (await column(page, "Length")).map((text) => Number(text.replace(",", "")));
  assert.deepEqual(lengths, [...lengths].sort((a, b) => b - a));
  assert(lengths.every((length) => length >= 1 && length <= STEPS));
});

test("an episode is replayed by one press, and ends with the return of its row", async () => {
  const page = await openEpisodes("all", 4);
  await page.click("#episode-columns button:has-text('Return')");
  const row = page.locator(ROWS).filter({ has: page.locator("button") }).first();
  const [, value, , length, seed] = await row.locator("td").allTextContents();
  assert.notEqual(value, "0");
  await row.locator("button").click();
  await page.waitForURL("**/replay?*");
  await waitForText(page.locator("#verdict"), "Identical to the recording");
  await page.click("#last");
  await waitForText(figure(page, "#figures", "Step"), `${length} of ${length}`);
  assert.equal(await figure(page, "#figures", "Score").textContent(), value);
  assert.equal(await figure(page, "#figures", "Level seed").textContent(), seed);
});

test("every episode of the table can be replayed, also after its environment has ended others", async () => {
  const page = await openEpisodes("all", 20);
  assert((await column(page, "Recording")).every((text) => text === "Replay"));
  const environments = await column(page, "Environment");
  const earlier = environments.findLastIndex((environment, index) => environments.indexOf(environment) !== index);
  const row = page.locator(ROWS).nth(earlier);
  const [, value, , length] = await row.locator("td").allTextContents();
  await row.locator("button").click();
  await waitForText(page.locator("#verdict"), "Identical to the recording");
  await page.click("#last");
  await waitForText(figure(page, "#figures", "Step"), `${length} of ${length}`);
  assert.equal(await figure(page, "#figures", "Score").textContent(), value);
});

test("rows say that the recording is gone when the server has no memory for it", async () => {
  const small = await Server.start("--episode_history_bytes_max=6000");
  try {
    const pool = await Pool.open(small, ["maze"], 2, { pool_id: "small" });
    for (let step = 1; step <= 2000; step += 1) {
      await pool.step([step % 200 ? 4 : -1, step % 150 ? 4 : -1]);
    }
    const page = await it.open(small.page("/?pool=pools%2Fsmall"));
    await page.waitForFunction((rows) => document.querySelectorAll(rows).length === 23, ROWS);
    const recordings = await column(page, "Recording");
    const kept = recordings.indexOf("gone");
    assert(kept >= 2, `${recordings}`);
    assert.deepEqual(recordings, recordings.map((_, index) => (index < kept ? "Replay" : "gone")));
    await waitForText(page.locator("#episodes-about"), /The recordings of the older ones are gone\.$/);
  } finally {
    assert.equal(await small.stop(), 0);
  }
});

test("charts describe the returns and the levels", async () => {
  const page = await openEpisodes("train", 5);
  const [returns, levels] = await page.locator("#episode-charts [role=img]").evaluateAll((all) =>
    all.map((one) => one.getAttribute("aria-label")));
  assert.match(returns, /^Returns: \d+ episodes, from \d+ to \d+, median \d+$/);
  assert.match(levels, /^Mean return by level seed: [1-3] levels?, of which \d were never completed$/);
  assert.equal(await page.locator("#episode-charts canvas").count(), 2);
  await page.locator("#episode-charts .u-over").first().hover({ position: { x: 10, y: 20 } });
  await waitForText(page.locator("#episode-charts .number").first(), / to .*: \d+ episodes?$/);
});
