// The mean returns of a random agent and a learner on the play page.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { join } from "node:path";
import { test } from "node:test";
import { waitForText, withBrowser } from "../browser.js";
import { BASELINES } from "../../../../server/web/pages/play/baselines.js";
import { withServer } from "../server.js";

const it = withBrowser();
const server = withServer();

test("the means of a random agent and of a learner are shown beside the score", async () => {
  const page = await it.open(server.page("/play?game=coinrun&mode=easy&level=1"));
  const [random, learner] = BASELINES.coinrun.easy;
  await waitForText(page.locator("#scores"), `Mean scores to compare with: random agent ${random}; PPO, 25 million steps ${learner}.`);
  await page.goto(server.page("/play?game=coinrun&mode=hard&level=3"));
  await waitForText(page.locator("#scores"), /: random agent 2\.52\.$/);
  await page.goto(server.page("/play?game=maze&mode=memory&level=3"));
  await waitForText(page.locator("#message"), "to begin.");
  assert.equal(await page.locator("#scores").textContent(), "");
});

test("the random agent's means are those of the measured facts", async () => {
  const facts = JSON.parse(await readFile(join(import.meta.dirname, "../../../../docs/game_facts.json"), "utf8"));
  const rows = Object.entries(facts).map(([game, { random_returns: { easy, hard } }]) => [game, { easy: easy.mean, hard: hard.mean }]);
  assert.equal(rows.length, 16);
  const random = Object.entries(BASELINES).map(([game, { easy, hard }]) => [game, { easy: easy[0], hard: hard[0] }]);
  assert.deepEqual(random, rows);
});

test("the learner's means are those that OpenAI published", async () => {
  const csv = await readFile(join(import.meta.dirname, "../../../../clients/python/learners/results/openai_ppo.csv"), "utf8");
  const [head, ...rows] = csv.trim().split("\n").map((line) => line.split(","));
  const mean = head.indexOf("return_mean");
  const last = rows.filter(([protocol, split, , steps]) => protocol === "easy-200" && split === "test" && steps === "25");
  const means = last.map((cells) => [cells[2], Number(Number(cells[mean]).toFixed(2))]);
  assert.equal(means.length, 16);
  assert.deepEqual(Object.entries(BASELINES).map(([game, { easy }]) => [game, easy[1]]), means);
});
