// Many viewers at once.

import assert from "node:assert/strict";
import { test } from "node:test";
import { waitForChange, waitForText, withBrowser } from "../browser.js";
import { Learner, Server } from "../server.js";

const VIEWER_COUNT = 20;
const FIRST = "#mosaic li:first-child canvas";
const it = withBrowser();

test("20 viewers receive the frames of one learner, and the learner continues", async () => {
  const server = await Server.start();
  await Learner.start(server, "watched", ["coinrun"], 16);
  const context = await it.browser.newContext({ viewport: { width: 500, height: 400 }, reducedMotion: "reduce" });
  const pages = await Promise.all(Array.from({ length: VIEWER_COUNT }, () => it.openIn(context, server.page())));
  await Promise.all(pages.map(async (page) => {
    await page.locator(FIRST).waitFor();
    for (let i = 0; i < 3; i += 1) {
      await waitForChange(page, FIRST);
    }
  }));
  assert.equal(await server.stop(), 0);
});

test("a page beyond the limit says so, and opens when another one is closed", async () => {
  const server = await Server.start("--web_viewers_max=1");
  const first = await it.open(server.page());
  await waitForText(first.locator(".link"), "Connected");
  const second = await it.open(server.page());
  await waitForText(second.locator("#outage"), "The server has no room for another page, --web_viewers_max is 1. "
    + "This page opens when another is closed.");
  await waitForText(second.locator(".link"), "Server is full");
  await first.close();
  await waitForText(second.locator(".link"), "Connected");
  await second.locator("#outage").waitFor({ state: "hidden" });
  assert.equal(await server.stop(), 0);
});
