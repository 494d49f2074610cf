// The pages of a fleet server with two nodes.

import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { figure, waitForChange, waitForText, withBrowser } from "./browser.js";
import { replayLastEpisode } from "./episodes.js";
import { COINRUN_1000, COINRUN_1000_PATH, COINRUN_1000_STEPS, playKeys } from "./playing.js";
import { Fleet, Learner } from "./server.js";

const ENV_COUNT = 8;
const it = withBrowser();
let fleet;
before(async () => { fleet = await Fleet.start("node-1", "node-2"); });
after(async () => assert.deepEqual(await fleet.stop(), [0, 0, 0]));

// Opens a page of the fleet server and waits until it lists all nodes.
async function openLive() {
  const page = await it.open(fleet.front.page());
  for (const name of ["front (fleet)", "node-1", "node-2"]) {
    await waitForState(page, name, "healthy");
  }
  return page;
}

function rowOf(page, name) {
  return page.locator("#node-rows tr", { has: page.getByText(name, { exact: true }) });
}

function waitForState(page, name, state) {
  return rowOf(page, name).locator(".badge", { hasText: state }).waitFor();
}

// Each node runs one half of the environments, so the first and the last frame come from different nodes.
async function waitForChangeOfBoth(page) {
  await waitForChange(page, "#mosaic li:first-child canvas");
  await waitForChange(page, "#mosaic li:last-child canvas");
}

test("the table lists all nodes and their load, and a pool on both is watched, saved and replayed", async () => {
  const page = await openLive();
  assert.equal(await page.locator("#node-rows tr").count(), 3);
  const learner = await Learner.start(fleet.front, "spread", ["coinrun"], ENV_COUNT);
  await waitForText(page.locator("#pool-name"), "pools/spread");
  for (const [name, node] of fleet.nodes) {
    await waitForText(rowOf(page, name), new RegExp(`${node.address}.*${ENV_COUNT / 2} of `));
  }
  await waitForText(rowOf(page, "front (fleet)"), new RegExp(`healthy${ENV_COUNT}1`));  // one pool; the fleet server has no capacity of its own
  await waitForChangeOfBoth(page);
  await waitForText(figure(page, "#pool-figures", "Episodes"), /^[1-9]/);
  await replayLastEpisode(page, ENV_COUNT);
  await waitForText(page.locator("#verdict"), "Identical to the recording");
  await learner.stop();
});

test("a level is played to its end through the fleet, and its replay is equal", async () => {
  await openLive();
  const page = await it.open(fleet.front.page(COINRUN_1000_PATH));
  await playKeys(page, COINRUN_1000);
  await waitForText(page.locator("#message"), `Level complete: score 10 in ${COINRUN_1000_STEPS} steps`);
  await page.click("#replay");
  await waitForText(page.locator("#verdict"), "Identical to the recording");
});

test("the table marks a stopped node until it returns, and watching continues", async () => {
  const page = await openLive();
  const learner = await Learner.start(fleet.front, "moved", ["coinrun"], ENV_COUNT);
  await waitForText(page.locator("#pool-name"), "pools/moved");
  assert.equal(await fleet.stopNode("node-2"), 0);
  await waitForState(page, "node-2", /^gone since \d\d:\d\d:\d\d$/);
  await waitForText(page.locator("#notices"), "node-2 was lost.");
  await waitForText(rowOf(page, "node-1"), `${ENV_COUNT} of `);
  await waitForChangeOfBoth(page);
  await fleet.startNode("node-2");
  await waitForState(page, "node-2", "healthy");
  assert.equal(await page.locator("#node-rows tr").count(), 3);
  await learner.stop();
});

test("the states of nodes are unknown while the fleet server does not answer", async () => {
  const page = await openLive();
  fleet.front.process.kill("SIGSTOP");
  await waitForState(page, "node-1", /^unknown$/);
  await waitForState(page, "front (fleet)", /^unknown$/);
  fleet.front.process.kill("SIGCONT");
  await waitForState(page, "node-1", "healthy");
});
