// What holds for every page: axe's rules, names, keyboard access, contrast in both themes, and no content outside the window.

import assert from "node:assert/strict";
import { test } from "node:test";
import { axeViolations } from "../axe.js";
import { lowContrasts } from "../contrast.js";
import { stickingOut } from "../overflow.js";

const WIDE = { width: 1440, height: 900 };
const USUAL = { width: 1280, height: 800 };
const NARROW = { width: 390, height: 844 };

const NAMED = [
  "button", "link", "checkbox", "radio", "combobox", "spinbutton", "slider", "textbox", "image", "dialog", "navigation",
];

// The accessibility tree: [role, name] of all enabled elements.
async function accessibleNodes(page) {
  const session = await page.context().newCDPSession(page);
  const { nodes } = await session.send("Accessibility.getFullAXTree");
  return nodes.filter(({ ignored }) => !ignored).map(({ role, name }) => [role.value, name?.value ?? ""]);
}

async function checkNames(page) {
  const nodes = await accessibleNodes(page);
  assert(nodes.some(([role]) => role === "button" || role === "link"));
  assert.deepEqual(nodes.filter(([role, text]) => NAMED.includes(role) && text.trim() === ""), []);
  assert.equal(await page.getAttribute("html", "lang"), "en");
  assert.match(await page.title(), /^.+ – Procgen Server$/);
  assert.equal(await page.locator("main").count(), 1);
  const headings = await page.locator("h1, h2, h3").evaluateAll((all) =>
    all.filter((one) => one.checkVisibility()).map((one) => Number(one.tagName[1])));
  assert(headings.every((level, i) => level <= (headings[i - 1] ?? 1) + 1), `levels of headings: ${headings}`);
}

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

async function checkKeyboard(page) {
  const wanted = await markReachable(page);
  const reached = new Set();
  for (let i = 0; i < wanted.length + 20; i += 1) {
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
  }
  assert.deepEqual(wanted.filter((one) => !reached.has(one)), []);
}

async function checkLooks(page) {
  // axe takes a second, so it sees each theme once.
  for (const [viewport, colorScheme] of [[WIDE, "light"], [NARROW, "dark"]]) {
    await page.setViewportSize(viewport);
    // With reduced motion colors change at once.
    await page.emulateMedia({ colorScheme, reducedMotion: "reduce" });
    assert.deepEqual(await page.evaluate(lowContrasts), [], colorScheme);
    assert.deepEqual(await axeViolations(page), [], `${colorScheme}, ${viewport.width} pixels`);
  }
  for (const viewport of [NARROW, USUAL, WIDE]) {
    await page.setViewportSize(viewport);
    assert.equal(await page.getByRole("heading", { level: 1 }).count(), 1, "readers of any window hear what the page is");
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
      await checkNames(page);
      await checkKeyboard(page);
      await checkLooks(page);
    });
  }
}
