// A headless Chromium for the tests of a file, and what they look at in it.

import assert from "node:assert/strict";
import { after, before } from "node:test";
import { chromium } from "playwright-core";

// `it.open(address)` opens a page that is closed after the last test; a page that reports an error fails it.
export function withBrowser() {
  const it = { errors: [] };
  before(async () => {
    it.browser = await chromium.launch({ executablePath: process.env.PROCGEN_CHROMIUM });
  });
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
  const term = page.locator(`${list} dt`, { hasText: new RegExp(`^${name}$`) });
  return page.locator(`${list} div`, { has: term }).locator("dd");
}

// Waits until an element has this text.
export async function waitForText(locator, text) {
  await locator.filter({ hasText: text }).waitFor();
}

// What a canvas shows, as text that can be compared.
export function picture(page, selector) {
  return page.locator(selector).first().evaluate((canvas) => canvas.toDataURL());
}

// Waits until a canvas shows something else than `before`.
export function waitForChange(page, selector, before) {
  return page.waitForFunction(([name, old]) => document.querySelector(name).toDataURL() !== old, [selector, before]);
}
