// A headless Chromium for the tests of a file, and what they look at in it.

import assert from "node:assert/strict";
import { createHash } from "node:crypto";
import { after, afterEach, before } from "node:test";
import { chromium } from "playwright-core";

// `it.open(address)` opens a page that is closed after the test; a page that reports an error fails the file.
export function withBrowser() {
  const it = { errors: [] };
  before(async () => {
    it.browser = await chromium.launch({ executablePath: process.env.PROCGEN_CHROMIUM });
  });
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

// The text of the figure of this name among those in `list`.
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

// What a canvas shows, as a short text that can be compared.
export async function picture(page, selector) {
  const content = await page.locator(selector).first().evaluate((canvas) => canvas.toDataURL());
  return createHash("sha256").update(content).digest("hex");
}

// Waits until what a canvas shows is as wanted.
export async function waitForPicture(page, selector, isWanted) {
  const begin = performance.now();
  while (!isWanted(await picture(page, selector))) {
    assert(performance.now() - begin < 60_000, `${selector} does not show what is wanted`);
    await page.evaluate(() => new Promise(requestAnimationFrame));
  }
}

// Waits until a canvas shows something else than now.
export async function waitForChange(page, selector) {
  const before = await page.locator(selector).first().evaluate((canvas) => canvas.toDataURL());
  await page.waitForFunction(([name, old]) => document.querySelector(name).toDataURL() !== old, [selector, before]);
}
