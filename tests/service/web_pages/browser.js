// A headless browser for the tests of a file, and helpers that read its pages.

import assert from "node:assert/strict";
import { createHash } from "node:crypto";
import { after, afterEach, before } from "node:test";
import { chromium } from "playwright-core";

function launchChromium() {
  return chromium.launch({ executablePath: process.env.PROCGEN_CHROMIUM });
}

// `it.open(address)` opens a page and closes it after the test. An error on a page fails the file. `launch()` starts the
// browser.
export function withBrowser(launch = launchChromium) {
  const it = { errors: [] };
  before(async () => { it.browser = await launch(); });
  afterEach(() => Promise.all(it.browser.contexts().map((context) => context.close())));
  after(async () => {
    await it.browser.close();
    assert.deepEqual(it.errors, []);
  });
  it.open = async (address, options = {}) => {
    const context = await it.browser.newContext({ viewport: { width: 1280, height: 800 }, ...options });
    return it.openIn(context, address);
  };
  it.openIn = async (context, address) => {
    const page = await context.newPage();
    page.setDefaultTimeout(60_000);
    page.on("pageerror", (error) => it.errors.push(`${address}: ${error.stack}`));
    await page.goto(address);
    return page;
  };
  return it;
}

// The text of the figure with this label in `list`.
export function figure(page, list, name) {
  const term = page.locator("dt", { hasText: new RegExp(`^${name}$`) });
  return page.locator(`${list} div`, { has: term }).locator("dd");
}

// Waits until an element has this text.
export async function waitForText(locator, text) {
  await locator.filter({ hasText: text }).waitFor();
}

// Enters a token into a page that requires one.
export async function enterToken(page, token) {
  await page.fill("#token", token);
  await page.keyboard.press("Enter");
}

// Waits until something is drawn on a canvas.
export async function waitForDrawing(page, selector) {
  await page.waitForFunction((name) => {
    const canvas = document.querySelector(name);
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    return data.some((value, index) => index % 4 < 3 && value > 0);
  }, selector);
}

// The content of a canvas, as a short string for comparisons.
export async function picture(page, selector) {
  const content = await page.locator(selector).first().evaluate((canvas) => canvas.toDataURL());
  return createHash("sha256").update(content).digest("hex");
}

// Waits until the content of a canvas satisfies a condition.
export async function waitForPicture(page, selector, isWanted) {
  const begin = performance.now();
  while (!isWanted(await picture(page, selector))) {
    assert(performance.now() - begin < 60_000, `${selector} does not show what is wanted`);
    await page.evaluate(() => new Promise(requestAnimationFrame));
  }
}

// Waits until the content of a canvas changes.
export async function waitForChange(page, selector) {
  const before = await page.locator(selector).first().evaluate((canvas) => canvas.toDataURL());
  await page.waitForFunction(([name, old]) => document.querySelector(name).toDataURL() !== old, [selector, before]);
}
