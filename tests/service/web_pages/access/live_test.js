// Accessibility of the live view, with and without pools.

import assert from "node:assert/strict";
import { mkdtemp, rm, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { enterToken, waitForText, withBrowser } from "../browser.js";
import { Learner, Server } from "../server.js";
import { testPages } from "./checks.js";

const it = withBrowser();
let server;
let empty;
let secured;
let folder;
let learner;
before(async () => {
  folder = await mkdtemp(join(tmpdir(), "procgen-web-"));
  await writeFile(join(folder, "tokens"), "alice alices-token-0123456789\n", { mode: 0o600 });
  secured = await Server.start(`--tokens=${join(folder, "tokens")}`);
  empty = await Server.start();
  server = await Server.start();
  learner = await Learner.start(server, "watched", ["coinrun"], 20);
});
after(async () => {
  await learner.stop();
  assert.equal(await server.stop(), 0);
  assert.equal(await empty.stop(), 0);
  assert.equal(await secured.stop(), 0);
  await rm(folder, { recursive: true });
});

// Each page, with its content in use.
const PAGES = {
  live: async (page) => {
    await page.goto(server.page());
    await page.locator("#plots canvas").first().waitFor();
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
