// Many viewers at once.

import assert from "node:assert/strict";
import { test } from "node:test";
import { waitForChange, withBrowser } from "./browser.js";
import { Learner, Server } from "./server.js";

const VIEWER_COUNT = 20;
const FIRST = "#mosaic li:first-child canvas";
const it = withBrowser();

test("20 viewers receive the frames of one learner, and the learner continues", async () => {
  const server = await Server.start();
  const learner = await Learner.start(server, "watched", ["coinrun"], 16);
  const context = await it.browser.newContext({ viewport: { width: 500, height: 400 }, reducedMotion: "reduce" });
  const pages = await Promise.all(Array.from({ length: VIEWER_COUNT }, () => it.openIn(context, server.page())));
  await Promise.all(pages.map(async (page) => {
    await page.locator(FIRST).waitFor();
    for (let i = 0; i < 3; i += 1) {
      await waitForChange(page, FIRST);
    }
  }));
  await learner.stop();
  assert.equal(await server.stop(), 0);
});
