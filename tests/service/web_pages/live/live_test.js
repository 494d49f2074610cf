// The live view of a running learner.

import assert from "node:assert/strict";
import { before, test } from "node:test";
import { figure, picture, waitForChange, waitForText, withBrowser } from "../browser.js";
import { replayLastEpisode } from "../episodes.js";
import { Learner, Server, withServer } from "../server.js";

const FIRST = "#mosaic li:first-child canvas";
const it = withBrowser();
const server = withServer();
before(() => Learner.start(server, "watched", ["coinrun"], 20));

async function openLive(path = "/", options = {}) {
  const page = await it.open(server.page(path), options);
  await page.locator(FIRST).waitFor();
  return page;
}

test("frames change while the learner steps, and stop while paused", async () => {
  const page = await openLive();
  assert.equal(await page.title(), "pools/watched – Procgen Server");
  assert.equal(await page.locator("#pool-name").textContent(), "pools/watched");
  await waitForText(page.locator("#pool-state"), "running");
  for (let i = 0; i < 5; i += 1) {
    await waitForChange(page, FIRST);
  }
  await page.click("#hold");
  assert.equal(await page.getAttribute("#hold", "aria-pressed"), "true");
  // Frames in transit arrive before the server's next message.
  const steps = figure(page, "#pool-figures", "Steps so far");
  const before = await steps.textContent();
  await page.waitForFunction((old) => document.querySelector("#pool-figures div:last-child dd").textContent !== old, before);
  const held = await picture(page, FIRST);
  const later = await steps.textContent();
  await page.waitForFunction((old) => document.querySelector("#pool-figures div:last-child dd").textContent !== old, later);
  assert.equal(await picture(page, FIRST), held);
  await page.click("#hold");
  await waitForChange(page, FIRST);
});

test("views are for agents or people, and environments are shown in pages", async () => {
  const page = await openLive();
  assert.equal(await page.locator("#mosaic canvas").count(), 16);
  await page.click("label:has-text('Human')");
  await page.waitForFunction((name) => document.querySelector(name).width > 64, FIRST);
  await page.click("label:has-text('Agent')");
  await page.waitForFunction((name) => document.querySelector(name).width === 64, FIRST);
  await page.click("#later");
  assert.equal(await page.locator("#range").textContent(), "to 19 of 20");
  await page.locator("#mosaic button[title='Environment 19']").waitFor();
  assert.equal(await page.locator("#mosaic canvas").count(), 4);
  await page.selectOption("#shown", "4");
  assert.equal(await page.locator("#range").textContent(), "to 19 of 20");
  await waitForChange(page, FIRST);
});

test("an environment is enlarged, and its last episode is saved and replayed exactly", async () => {
  const page = await openLive();
  await waitForText(figure(page, "#pool-figures", "Episodes"), /^[1-9]/);
  // The mosaic behind the dialog stops.
  await page.click("#mosaic button[title='Environment 2']");
  await waitForText(page.locator("#large-title"), "pools/watched, environment 2");
  await waitForChange(page, "#large-picture");
  const covered = await page.locator("#mosaic canvas").evaluateAll((all) => all.map((one) => one.toDataURL()));
  for (let i = 0; i < 3; i += 1) {
    await waitForChange(page, "#large-picture");
  }
  assert.deepEqual(await page.locator("#mosaic canvas").evaluateAll((all) => all.map((one) => one.toDataURL())), covered);
  await waitForChange(page, "#large-picture");
  await page.keyboard.press("ArrowRight");
  await waitForText(page.locator("#large-title"), "pools/watched, environment 3");
  await page.keyboard.press("Escape");
  await page.locator("#large").waitFor({ state: "hidden" });

  await replayLastEpisode(page, 16);
  await waitForText(page.locator("#verdict"), "Identical to the recording");
  await waitForText(page.locator("#level"), "coinrun");
});

test("a page without pools shows instructions, and then a new pool", async () => {
  const empty = await Server.start();
  const page = await it.open(empty.page());
  await page.locator("#empty").waitFor();
  await waitForText(page.locator("#empty pre"), `ProcgenVectorEnv("coinrun", num_envs=64, server="${empty.address}")`);
  const first = await Learner.start(empty, "first", ["maze"], 4);
  await waitForText(page.locator("#pool-name"), "pools/first");
  await page.locator("#empty").waitFor({ state: "hidden" });
  await first.stop();
  await page.locator("#empty").waitFor();
  assert.equal(await empty.stop(), 0);
});

test("pools of plays are hidden", async () => {
  const player = await it.open(server.page("/play?game=maze&mode=easy&level=1"));
  await waitForText(figure(player, "#figures", "Level seed"), /^1$/);
  const page = await openLive();
  assert.equal(await page.locator("#pools tr").count(), 1);
  for (const [name, value] of [["Pools", "1"], ["Environments", "20"]]) {
    assert.equal(await figure(page, "#server", name).textContent(), value, `${name} without those of pages`);
  }
});
