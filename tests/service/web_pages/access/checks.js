// What holds for every page: axe's rules (names, headings, contrast), keyboard access, and no content outside the window.

import assert from "node:assert/strict";
import { test } from "node:test";
import { axeViolations } from "../axe.js";
import { faintControls } from "../contrast.js";
import { stickingOut } from "../overflow.js";

const WIDE = { width: 1440, height: 900 };
const USUAL = { width: 1280, height: 800 };
const NARROW = { width: 390, height: 844 };

// Marks the elements that the keyboard must reach; returns the marks.
function markReachable(page) {
  return page.evaluate(() => {
    const root = document.querySelector("dialog[open]") ?? document.body;
    const all = root.querySelectorAll("a[href], button, select, input, summary");
    const marks = [...all].filter((one) => one.checkVisibility() && !one.disabled).map((one, i) => {
      one.dataset.reached = one.type === "radio" ? `group ${one.name}` : `${one.tagName} ${i} ${one.id}`;
      return one.dataset.reached;
    });
    document.activeElement.blur();
    return [...new Set(marks)];
  });
}

// Those of the marks whose elements are still there; rows of a table are replaced when an episode ends.
function presentMarks(page) {
  return page.evaluate(() => [...document.querySelectorAll("[data-reached]")].map((one) => one.dataset.reached));
}

async function checkKeyboard(page) {
  const marks = await markReachable(page);
  assert(marks.length > 0);
  const reached = new Set();
  let missing = marks;
  // New rows add elements without marks.
  for (let i = 0; i < 5 * marks.length + 20 && missing.length > 0; i += 1) {
    await page.keyboard.press("Tab");
    const [what, isSeen] = await page.evaluate(() => {
      const focused = document.activeElement;
      const shown = focused.closest(".choice, .open .button") ?? focused;
      const { outlineStyle, outlineWidth } = getComputedStyle(shown);
      return [focused.dataset.reached, outlineStyle !== "none" && parseFloat(outlineWidth) >= 2];
    });
    if (what) {
      reached.add(what);
      assert(isSeen, `the focus on ${what} is not seen`);
    }
    missing = (await presentMarks(page)).filter((mark) => !reached.has(mark));
  }
  assert.deepEqual(missing, []);
}

async function checkLooks(page) {
  for (const [viewport, colorScheme] of [[WIDE, "light"], [USUAL, "dark"], [NARROW, "light"]]) {
    await page.setViewportSize(viewport);
    // With reduced motion colors change at once.
    await page.emulateMedia({ colorScheme, reducedMotion: "reduce" });
    assert.deepEqual(await page.evaluate(faintControls), [], colorScheme);
    assert.deepEqual(await axeViolations(page), [], `${colorScheme}, ${viewport.width} pixels`);
    assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), viewport.width);
    assert.deepEqual(await page.evaluate(stickingOut), [], `${viewport.width} pixels`);
  }
}

// Adds a test for each of `pages`: functions, by a name, that take a tab with any page and open and use that page. `anyPage()` is
// the URL of one.
export function testPages(it, pages, anyPage) {
  for (const [name, use] of Object.entries(pages)) {
    test(`${name}: elements have names, keyboard access and contrast, and fit the window`, async () => {
      const page = await it.open(anyPage(), { viewport: WIDE });
      await use(page);
      await checkKeyboard(page);
      await checkLooks(page);
    });
  }
}
