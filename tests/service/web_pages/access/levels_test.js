// Accessibility of play, replay and gallery.

import assert from "node:assert/strict";
import { join } from "node:path";
import { test } from "node:test";
import { axeViolations } from "../axe.js";
import { figure, waitForText, withBrowser } from "../browser.js";
import { COINRUN_1000, COINRUN_1000_PATH, playKeys } from "../playing.js";
import { withServer } from "../server.js";
import { testPages } from "./checks.js";

const it = withBrowser();
const server = withServer();

// Each page, with its content in use.
const PAGES = {
  play: async (page) => {
    await page.goto(server.page(COINRUN_1000_PATH));
    await waitForText(page.locator("#message"), "Press an arrow key to begin.");
    await page.click("summary");
  },
  "replay without a trace": async (page) => {
    await page.goto(server.page("/replay"));
    await waitForText(page.locator(".link"), "Connected");
  },
  replay: async (page) => {
    await page.goto(server.page(COINRUN_1000_PATH));
    await playKeys(page, COINRUN_1000.slice(0, 2));
    await page.click("#replay");
    await waitForText(figure(page, "#figures", "Step"), "0 of 3");
  },
  "the end of a replay": async (page) => {
    await page.goto(server.page(COINRUN_1000_PATH));
    await playKeys(page, COINRUN_1000);
    await waitForText(page.locator("#message"), "Level complete");
    await page.click("#replay");
    await page.click("#last");
    await waitForText(figure(page, "#figures", "Episode"), "complete");
  },
  "the map of a replay": async (page) => {
    await PAGES.replay(page);
    await page.click("#map summary");
    await waitForText(page.locator("#map-about"), "Level 1000");
  },
  "images and videos of a replay": async (page) => {
    await PAGES.replay(page);
    await page.click("#open-export");
  },
  "a comparison of two replays": async (page) => {
    await PAGES.replay(page);
    await page.click("#compare summary");
    await page.setInputFiles("#other-file", join(import.meta.dirname, "../../../conformance/golden/maze.easy.solved-1000.trace"));
    await waitForText(page.locator("#difference"), "First difference at step 0");
  },
  gallery: async (page) => {
    await page.goto(server.page("/gallery"));
    await page.waitForFunction(() => document.querySelectorAll(".strip canvas").length === 64);
  },
};

testPages(it, PAGES, () => server.page("/play"));

test("axe finds what is wrong", async () => {
  const page = await it.open(server.page("/gallery"));
  await page.evaluate(() => document.querySelector("main").append(document.createElement("button")));
  const [violation] = await axeViolations(page);
  assert.match(violation, /^button-name /);
});

test("the header can be skipped", async () => {
  for (const path of ["/", "/play", "/replay", "/gallery"]) {
    const page = await it.open(server.page(path));
    await waitForText(page.locator(".link"), "Connected");
    const target = await page.getAttribute(".skip", "href");
    await page.locator(".skip").focus();
    await page.keyboard.press("Enter");
    await page.locator(`${target}:focus`).waitFor();
  }
});
