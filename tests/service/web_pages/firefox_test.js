// The pages in Firefox: what differs between browsers, such as canvases, images, keys, downloads and videos.

import assert from "node:assert/strict";
import { execFile } from "node:child_process";
import { readFile } from "node:fs/promises";
import { before, test } from "node:test";
import { promisify } from "node:util";
import { figure, picture, waitForChange, waitForDrawing, waitForPicture, waitForText } from "./browser.js";
import { withFirefox } from "./firefox.js";
import { COINRUN_1000, COINRUN_1000_ACTIONS, COINRUN_1000_PATH, COINRUN_1000_STEPS, playKeys } from "./playing.js";
import { decode, differenceFrom } from "./saved_images.js";
import { Learner, Pool, withServer } from "./server.js";

const FIRST = "#mosaic li:first-child canvas";
const STEPS_PER_SECOND = 15;

const it = withFirefox();
const server = withServer();
let replay;  // the path of the replay of an ended episode
before(async () => {
  await endEpisode("ended");
  await Learner.start(server, "watched", ["coinrun"], 20);
});

// Plays coinrun's level 1000 to its coin in a pool of one environment.
async function endEpisode(poolId) {
  const pool = await Pool.open(server, ["coinrun"], 1, { pool_id: poolId, start_level: 1000, num_levels: 1 });
  for (const action of COINRUN_1000_ACTIONS) {
    await pool.step([action]);
  }
  replay = `/replay?pool=${encodeURIComponent(pool.name)}&environment=0`;
}

async function openLive(query = "") {
  const page = await it.open(server.page(`/${query}`));
  await page.locator(FIRST).waitFor();
  return page;
}

function step(page) {
  return figure(page, "#figures", "Step");
}

async function openReplay(number = 0) {
  const page = await it.open(server.page(`${replay}&step=${number}`));
  await waitForText(step(page), `${number} of ${COINRUN_1000_STEPS}`);
  return page;
}

test("the live view shows frames, figures and plots of a running learner", async () => {
  const page = await openLive("?pool=pools%2Fwatched");
  assert.equal(await page.locator("#mosaic canvas").count(), 16);
  await waitForDrawing(page, FIRST);
  for (let i = 0; i < 3; i += 1) {
    await waitForChange(page, FIRST);
  }
  assert.equal(await figure(page, "#pool-figures", "Environments").textContent(), "20");
  await waitForText(figure(page, "#pool-figures", "Steps so far"), /^[1-9]/);
  assert.equal(await page.locator("#plots .plot canvas").count(), 4);
  await page.locator("#plots [role=img][aria-label*='now ']").first().waitFor();
  await waitForDrawing(page, "#plots .plot canvas");
});

test("an ended episode is a row of the table, whose button replays it", async () => {
  const page = await openLive("?pool=pools%2Fended");
  const rows = page.locator("#episode-rows tr");
  await rows.first().waitFor();
  assert.equal(await rows.count(), 1);
  await rows.locator("button").click();
  await page.waitForURL("**/replay?*");
  await waitForText(page.locator("#verdict"), "Identical to the recording");
  await waitForText(step(page), `0 of ${COINRUN_1000_STEPS}`);
});

test("keys play a level to its end, and procgen-conformance replays the saved trace bit for bit", async () => {
  const page = await it.open(server.page(COINRUN_1000_PATH));
  await waitForText(step(page), /^0$/);
  const start = await picture(page, "#human");
  await playKeys(page, COINRUN_1000);
  await waitForText(page.locator("#message"), `Level complete: score 10 in ${COINRUN_1000_STEPS} steps`);
  await waitForPicture(page, "#human", (shown) => shown !== start);
  const trace = await it.save(page, "#save", /^coinrun.*1000.*\.trace$/);
  const { stdout } = await promisify(execFile)(process.env.PROCGEN_CONFORMANCE, [trace]);
  assert.match(stdout, /^1 passed, 0 failed, 0 skipped$/m);
});

test("an image and a video of a replay are saved, and show what the page shows", async () => {
  const shown = 20;
  const page = await openReplay(shown);
  await waitForDrawing(page, "#human");
  await page.click("#open-export");
  const image = await readFile(await it.save(page, "#export-image", new RegExp(`^coinrun.*\\.human\\.step-${shown}\\.png$`)));
  assert.deepEqual(await differenceFrom(page, "#human", image.toString("base64")), { size: 512, difference: 0 });
  const video = await readFile(await it.save(page, "#export-video", /^coinrun.*\.human\.mp4$/));
  const { width, height, duration, content } = await decode(it, video.toString("base64"), (shown + 0.5) / STEPS_PER_SECOND);
  assert.deepEqual([width, height], [512, 512]);
  assert(Math.abs(duration - (COINRUN_1000_STEPS + 1) / STEPS_PER_SECOND) < 0.05, `${duration} s`);
  const { difference } = await differenceFrom(page, "#human", content);
  assert(difference < 4, `the frame differs by ${difference}`);
});
