// Accessibility of the live view, with and without pools.

import assert from "node:assert/strict";
import { writeFileSync } from "node:fs";
import { join } from "node:path";
import { before, test } from "node:test";
import { enterToken, waitForText, withBrowser } from "../browser.js";
import { Learner, withFolder, withServer } from "../server.js";
import { testPages } from "./checks.js";

const it = withBrowser();
const server = withServer();
const empty = withServer();
const folder = withFolder();
writeFileSync(join(folder, "tokens"), "alice alices-token-0123456789\n", { mode: 0o600 });
const secured = withServer(`--tokens=${join(folder, "tokens")}`);
before(() => Learner.start(server, "watched", ["coinrun"], 20));

// Each page, with its content in use.
const PAGES = {
  live: async (page) => {
    await page.goto(server.page());
    await page.locator("#plots canvas").first().waitFor();
    await page.locator("#mosaic .result").first().waitFor();
    await page.locator("#hold").click();
  },
  "live without pools": async (page) => {
    await page.goto(empty.page());
    await page.locator("#empty").waitFor();
  },
  "an enlarged environment": async (page) => {
    await page.goto(server.page());
    await page.locator("#mosaic button").first().click();
  },
  "the request for a token": async (page) => {
    await page.goto(secured.page());
    await enterToken(page, "wrong-token-0123456789");
    await waitForText(page.locator("#token-problem"), "The server does not know this token.");
  },
};

testPages(it, PAGES, () => empty.page("/play"));

test("reduced motion limits frames to one a second", async () => {
  const page = await it.open(server.page(), { reducedMotion: "reduce" });
  assert.equal(await page.inputValue("#rate"), "1");
});
