// The plots of pools: cursor, zoom, spans, axes, band, comparison, CSV.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { before, test } from "node:test";
import { waitForText, withBrowser } from "../browser.js";
import { Learner, withServer } from "../server.js";

const FIRST = "#plots .plot:has(h3:has-text('Steps per second')) .drawing";
const RETURNS = "#plots .plot:has(h3:has-text('Mean return'))";
const it = withBrowser();
const server = withServer();
before(async () => {
  await Learner.start(server, "one", ["coinrun"], 32);
  await Learner.start(server, "two", ["coinrun"], 32);
  await Learner.start(server, "mixed", ["coinrun", "maze"], 32);
});

// Opens the plots of a pool with at least five seconds of history, in which episodes have ended.
async function openPlots(pool) {
  const page = await it.open(server.page(`/?pool=pools%2F${pool}`));
  await page.locator("#plots canvas").nth(3).waitFor();
  await waitForText(page.locator(`${RETURNS} .number span`).first(), /\d/);
  return page;
}

// Moves the pointer over the first plot, to a part of its width.
async function point(page, part) {
  const box = await page.locator(".u-over").first().boundingBox();
  await page.mouse.move(box.x + box.width * part, box.y + box.height / 2);
}

test("the cursor shows the values of all plots at its time", async () => {
  const page = await openPlots("one");
  await page.locator(FIRST).scrollIntoViewIfNeeded();
  await point(page, 0.5);
  const times = page.locator("#plots h3 .quiet");
  await page.waitForFunction(() => [...document.querySelectorAll("#plots h3 .quiet")].every((one) => /^\d\d:\d\d:\d\d$/.test(one.textContent)));
  assert.equal(new Set(await times.allTextContents()).size, 1);
  await page.mouse.move(0, 0);
  await page.waitForFunction(() => [...document.querySelectorAll("#plots h3 .quiet")].every((one) => one.textContent === ""));
});

test("dragging zooms all plots, until the zoom is reset", async () => {
  const page = await openPlots("one");
  assert(await page.isDisabled("#unzoom"));
  await page.locator(FIRST).scrollIntoViewIfNeeded();
  await point(page, 0.25);
  await page.mouse.down();
  await point(page, 0.75);
  await page.mouse.up();
  await page.waitForFunction(() => !document.querySelector("#unzoom").disabled);
  await page.click("#unzoom");
  assert(await page.isDisabled("#unzoom"));
});

test("a pool of several games has a line for each", async () => {
  const page = await openPlots("mixed");
  await waitForText(page.locator(`${RETURNS} .number`), /coinrun [\d.]+.*maze [\d.]+/);
});

test("pools are compared, with a line for each, and saved as CSV", async () => {
  const page = await openPlots("one");
  await page.getByLabel("Compare pools/two").check();
  await waitForText(page.locator("#plots .number").first(), /pools\/one \S+pools\/two \S+/);
  assert(await page.getByLabel("Compare pools/one").isDisabled());
  await page.selectOption("#x", { label: "Over steps" });
  await page.waitForFunction((first) => / over steps, /.test(document.querySelector(first).getAttribute("aria-label")), "#plots .drawing");
  // The pools have done different numbers of steps.
  await waitForText(page.locator(`${RETURNS} .number`), /pools\/one [\d.]+pools\/two [\d.]+/);
  const download = page.waitForEvent("download");
  await page.click("#csv");
  const file = await download;
  assert.equal(file.suggestedFilename(), "one-two.csv");
  const [header, ...lines] = (await readFile(await file.path(), "utf8")).trim().split("\n");
  assert.match(header, /^pool,time,step_count,steps_per_second,.*,return_deviation$/);
  const width = header.split(",").length;
  assert(lines.every((line) => line.split(",").length === width));
  assert.deepEqual([...new Set(lines.map((line) => line.split(",")[0]))], ["pools/one", "pools/two"]);
  assert(lines.every((line) => !Number.isNaN(Date.parse(line.split(",")[1]))));
  await page.getByLabel("Compare pools/two").uncheck();
  await waitForText(page.locator("#plots .number").first(), /^[\d.]+ \(.*\)random agent/);
});
