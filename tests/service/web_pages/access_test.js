// Accessibility of every page: axe's rules, names, keyboard, contrast in both themes, narrow windows, reduced motion.

import assert from "node:assert/strict";
import { mkdtemp, rm, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { axeViolations } from "./axe.js";
import { enterToken, figure, waitForText, withBrowser } from "./browser.js";
import { lowContrasts } from "./contrast.js";
import { stickingOut } from "./overflow.js";
import { COINRUN_1000, COINRUN_1000_PATH, playKeys } from "./playing.js";
import { Learner, Server } from "./server.js";

const WIDE = { width: 1440, height: 900 };
const USUAL = { width: 1280, height: 800 };
const NARROW = { width: 390, height: 844 };

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
  "the deletion of a pool": async (page) => {
    await page.goto(server.page());
    await page.getByRole("button", { name: "Delete pools/watched" }).click();
    await waitForText(page.locator("#delete-title"), "Delete pools/watched?");
  },
  play: async (page) => {
    await page.goto(server.page(COINRUN_1000_PATH));
    await waitForText(page.locator("#message"), "Press an arrow key to begin.");
    await page.click("summary");
  },
  "replay without a trace": async (page) => {
    await page.goto(empty.page("/replay"));
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
    await page.setInputFiles("#other-file", join(import.meta.dirname, "../../conformance/golden/maze.easy.solved-1000.trace"));
    await waitForText(page.locator("#difference"), "First difference at step 0");
  },
  "a wrong link": async (page) => {
    await page.goto(server.page("/play?game=pong"));
    await page.locator("#wrong").waitFor();
  },
  gallery: async (page) => {
    await page.goto(server.page("/gallery"));
    await page.waitForFunction(() => document.querySelectorAll(".strip canvas").length === 64);
  },
  "levels of a game": async (page) => {
    await page.goto(server.page("/gallery?game=maze&mode=easy&level=24"));
    await page.locator("#pictures canvas").first().waitFor();
  },
};

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
  assert(nodes.filter(([role]) => role === "button").length > 0);
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
  for (const viewport of [WIDE, USUAL, NARROW]) {
    await page.setViewportSize(viewport);
    assert.equal(await page.getByRole("heading", { level: 1 }).count(), 1, "readers of any window hear what the page is");
    for (const colorScheme of ["light", "dark"]) {
      // With reduced motion colors change at once.
      await page.emulateMedia({ colorScheme, reducedMotion: "reduce" });
      assert.deepEqual(await page.evaluate(lowContrasts), [], colorScheme);
      assert.deepEqual(await axeViolations(page), [], `${colorScheme}, ${viewport.width} pixels`);
    }
    assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), viewport.width);
    assert.deepEqual(await page.evaluate(stickingOut), [], `${viewport.width} pixels`);
  }
}

for (const [name, use] of Object.entries(PAGES)) {
  test(`${name}: elements have names, keyboard access and contrast, and fit the window`, async () => {
    const page = await it.open(server.page("/play"), { viewport: WIDE });
    await use(page);
    await checkNames(page);
    await checkKeyboard(page);
    await checkLooks(page);
  });
}

test("axe finds what is wrong", async () => {
  const page = await it.open(empty.page("/gallery"));
  await page.evaluate(() => document.querySelector("main").append(document.createElement("button")));
  const [violation] = await axeViolations(page);
  assert.match(violation, /^button-name /);
});

test("the header can be skipped", async () => {
  for (const path of ["/", "/play", "/replay", "/gallery"]) {
    const page = await it.open(empty.page(path));
    await waitForText(page.locator(".link"), "Connected");
    const target = await page.getAttribute(".skip", "href");
    await page.locator(".skip").focus();
    await page.keyboard.press("Enter");
    await page.locator(`${target}:focus`).waitFor();
  }
});

test("the theme follows the system until one is chosen, which applies to every page", async () => {
  const page = await it.open(server.page("/play"), { colorScheme: "dark" });
  const ground = () => page.evaluate(() => getComputedStyle(document.documentElement).backgroundColor);
  const dark = await ground();
  await page.emulateMedia({ colorScheme: "light" });
  const light = await ground();
  assert.notEqual(light, dark);
  await page.click("text=Dark");
  assert.equal(await ground(), dark);
  await page.goto(server.page("/gallery"));
  assert.equal(await ground(), dark);
});

test("reduced motion limits frames to one a second", async () => {
  const page = await it.open(server.page(), { reducedMotion: "reduce" });
  assert.equal(await page.inputValue("#rate"), "1");
});
