// Best scores of the browser on the play page, beside the mean returns of a random agent and a learner; and the help of the keys.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { waitForText, withBrowser } from "../browser.js";
import { COINRUN_1000, COINRUN_1000_PATH, playKeys } from "../playing.js";
import { LEARNER_BASELINE } from "../../../../server/web/pages/play/learner_baseline.js";
import { RANDOM_BASELINE } from "../../../../server/web/pages/play/random_baseline.js";
import { Server } from "../server.js";

const ROW = /^\| (\w+) \| (-?[\d.]+) ± [\d.]+ \| [\d.]+ \| (-?[\d.]+) ± /gm;

const it = withBrowser();
let server;
before(async () => { server = await Server.start(); });
after(async () => assert.equal(await server.stop(), 0));

// Ends the episode of coinrun's level 1000 with score 10.
async function win(page) {
  await playKeys(page, COINRUN_1000);
  await waitForText(page.locator("#message"), "Level complete: score 10");
  return page.locator("#message").textContent();
}

test("a best score is announced once, kept by the browser, and shown beside a random agent's mean", async () => {
  const page = await it.open(server.page(COINRUN_1000_PATH));
  const learner = String(LEARNER_BASELINE.coinrun.easy).replace(".", "\\.");
  await waitForText(page.locator("#scores"), new RegExp(`^A random agent's mean: 2.62\\. PPO's after 25 million steps: ${learner}\\.$`));
  assert.match(await win(page), /New best\./);
  await waitForText(page.locator("#scores"), /^Your best score in coinrun, easy: 10\. A random agent's mean: 2.62\. PPO's/);
  await page.reload();
  await waitForText(page.locator("#scores"), /^Your best score in coinrun, easy: 10\./);
  assert.doesNotMatch(await win(page), /New best/);
  await page.goto(server.page("/play?game=coinrun&mode=hard&level=3"));
  await waitForText(page.locator("#scores"), /^A random agent's mean: 2.44\.$/);
  await page.goto(server.page("/play?game=maze&mode=memory&level=3"));
  await waitForText(page.locator("#message"), "to begin.");
  assert.equal(await page.locator("#scores").textContent(), "");
});

test("a score of nothing is no best score", async () => {
  const page = await it.open(server.page("/play?game=leaper&mode=easy&level=1"));
  await waitForText(page.locator("#message"), "Press an arrow key to begin.");
  await page.keyboard.down("ArrowUp");
  await waitForText(page.locator("#message"), "Episode over: score 0");
  assert.doesNotMatch(await page.locator("#message").textContent(), /New best/);
  await page.keyboard.up("ArrowUp");
  assert.equal(await page.evaluate(() => localStorage.getItem("best scores")), null);
});

test("levels with other options and continued replays set no best score", async () => {
  const page = await it.open(server.page(`${COINRUN_1000_PATH}&use_backgrounds=false`));
  assert.doesNotMatch(await win(page), /New best/);
  assert.equal(await page.evaluate(() => localStorage.getItem("best scores")), null);

  await page.click("#replay");
  await page.locator("#row").fill("34");
  await page.waitForURL("**/replay?step=34");
  await page.click("#play-here");
  await waitForText(page.locator("#message"), "to begin.");
  await page.keyboard.down("ArrowRight");
  await page.keyboard.press(".");
  await waitForText(page.locator("#message"), "Level complete: score 10");
  assert.equal(await page.evaluate(() => localStorage.getItem("best scores")), null);
});

test("the random agent's means are those of the table of procgen-random-baseline", async () => {
  const table = await readFile(join(import.meta.dirname, "../../../../envcore/README.md"), "utf8");
  const rows = [...table.matchAll(ROW)].map(([, game, easy, hard]) => [game, { easy: Number(easy), hard: Number(hard) }]);
  assert.equal(rows.length, 16);
  assert.deepEqual(RANDOM_BASELINE, Object.fromEntries(rows));
});

test("the learner's means are those that OpenAI published", async () => {
  const csv = await readFile(join(import.meta.dirname, "../../../../clients/python/learners/results/openai_ppo.csv"), "utf8");
  const [head, ...rows] = csv.trim().split("\n").map((line) => line.split(","));
  const mean = head.indexOf("return_mean");
  const last = rows.filter(([protocol, split, , steps]) => protocol === "easy-200" && split === "test" && steps === "25");
  const means = last.map((cells) => [cells[2], { easy: Number(Number(cells[mean]).toFixed(2)) }]);
  assert.equal(means.length, 16);
  assert.deepEqual(LEARNER_BASELINE, Object.fromEntries(means));
});

test("keys with the same effect are explained together", async () => {
  const page = await it.open(server.page("/play?game=starpilot&mode=easy&level=1"));
  await waitForText(page.locator("#special_keys"), /^D, W, S, Q, E: Fires a bullet forwards\. A: Fires a bullet backwards\.$/);
});
