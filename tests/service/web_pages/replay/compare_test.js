// Two replays side by side, in step, and their first difference.

import assert from "node:assert/strict";
import { join } from "node:path";
import { before, test } from "node:test";
import { figure, picture, waitForPicture, waitForText, withBrowser } from "../browser.js";
import { Pool, withFolder, withServer } from "../server.js";

const STEPS = 30;
const DIFFERENT = 13;  // the step from which environment 1 acts differently
const [LEFT, NONE, RIGHT] = [1, 4, 7];

const it = withBrowser();
const server = withServer();
const folder = withFolder();
before(async () => {
  // Both environments play the same level.
  const pool = await Pool.open(server, ["coinrun"], 3, { pool_id: "two", num_levels: 1, start_level: 7, rand_seed: 0 });
  for (let step = 1; step < STEPS; step += 1) {
    await pool.step([RIGHT, step < DIFFERENT ? RIGHT : LEFT, NONE]);
  }
  await pool.step([-1, -1, NONE]);
});

async function openEpisode(environment) {
  const page = await it.open(server.page(`/replay?pool=pools%2Ftwo&environment=${environment}`));
  await waitForText(figure(page, "#figures", "Step"), `0 of ${STEPS}`);
  return page;
}

async function compareWith(page, environment) {
  if (!await page.locator("#compare").evaluate((details) => details.open)) {
    await page.click("#compare summary");
  }
  await page.selectOption("[name=pool]", "pools/two");
  const option = page.locator("[name=episode] option", { hasText: `environment ${environment}` });
  await option.waitFor({ state: "attached" });
  await page.selectOption("[name=episode]", await option.getAttribute("value"));
  await page.click("#other-pool button");
}

async function seek(page, step) {
  await page.locator("#row").fill(String(step));
  await waitForText(figure(page, "#figures", "Step"), `${step} of ${STEPS}`);
  await waitForText(page.locator("#other-name"), `step ${step} of ${STEPS}`);
}

test("two episodes are shown in step, and their first difference is named and gone to", async () => {
  const page = await openEpisode(0);
  await compareWith(page, 1);
  await waitForText(page.locator("#difference"),
    `First difference at step ${DIFFERENT}: the action is RIGHT, in pools/two, environment 1 it is LEFT.`);
  await seek(page, DIFFERENT - 1);
  const before = await picture(page, "#human");
  await waitForPicture(page, "#other", (one) => one === before);
  await page.click("#go-difference");
  await waitForText(figure(page, "#figures", "Step"), `${DIFFERENT} of ${STEPS}`);
  await seek(page, DIFFERENT + 5);
  const later = await picture(page, "#human");
  await waitForPicture(page, "#other", (one) => one !== before && one !== later);
  // As the replay of environment 1 shows it.
  const other = await openEpisode(1);
  await other.locator("#row").fill(String(DIFFERENT + 5));
  await waitForText(figure(other, "#figures", "Step"), `${DIFFERENT + 5} of ${STEPS}`);
  assert.equal(await picture(other, "#human"), await picture(page, "#other"));

  // The URL has both.
  await page.waitForURL(/&other_pool=pools%2Ftwo&other_environment=1&other_episode=[0-9a-f]{16}&step=18$/);
  const again = await it.open(page.url());
  await waitForText(again.locator("#difference"), `First difference at step ${DIFFERENT}: the action is RIGHT`);
  await waitForText(figure(again, "#figures", "Step"), `${DIFFERENT + 5} of ${STEPS}`);

  await page.setViewportSize({ width: 390, height: 844 });
  assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), 390);
  await page.setViewportSize({ width: 1280, height: 800 });
  await page.click("#end-compare");
  await page.locator("#other-figure").waitFor({ state: "hidden" });
  assert.equal(await page.locator("#difference").textContent(), "");
});

test("a trace from a file is compared, an equal one has no difference, and invalid ones are reported", async () => {
  const page = await openEpisode(0);
  const download = page.waitForEvent("download");
  await page.click("#save");
  const trace = join(folder, "same.trace");
  await (await download).saveAs(trace);
  await page.click("#compare summary");
  await page.setInputFiles("#other-file", trace);
  await waitForText(page.locator("#difference"), "No difference from same.trace.");
  assert.equal(await page.locator("#go-difference").isVisible(), false);

  await page.setInputFiles("#other-file", { name: "no.trace", mimeType: "text/plain", buffer: Buffer.from("none") });
  await waitForText(page.locator("#notices .bad"), "The file is not a trace");
  await waitForText(page.locator("#difference"), "No difference from same.trace.");

  const golden = join(import.meta.dirname, "../../../conformance/golden/maze.easy.solved-1000.trace");
  await page.setInputFiles("#other-file", golden);
  await waitForText(page.locator("#difference"), "First difference at step 0: the game is coinrun, in maze.easy.solved-1000.trace it is maze.");
  // The second replay stays when the first is replaced, and is compared with it.
  await page.setInputFiles("#file", golden);
  await waitForText(page.locator("#difference"), "No difference from maze.easy.solved-1000.trace.");
});
