// The gallery.

import assert from "node:assert/strict";
import { test } from "node:test";
import { figure, waitForText, withBrowser } from "./browser.js";
import { withServer } from "./server.js";

const it = withBrowser();
const server = withServer();

test("all games are shown with images and modes", async () => {
  const page = await it.open(server.page("/gallery"));
  await page.waitForFunction(() => document.querySelectorAll(".strip canvas").length === 64);
  assert.equal(await page.locator(".game").count(), 16);
  const modes = await page.locator(".game", { has: page.locator("h2", { hasText: "jumper" }) }).locator(".modes a").allTextContents();
  assert.deepEqual(modes, ["easy", "hard", "memory", "exploration"]);
});

test("levels are shown by seed in pages, and a click plays one", async () => {
  const page = await it.open(server.page("/gallery?game=maze&mode=hard&level=0"));
  await page.waitForFunction(() => document.querySelectorAll("#pictures canvas").length === 24);
  assert.equal(await page.locator("#previous").isVisible(), false);
  await page.click("#following");
  await page.locator("#pictures a[title='Level 47']").waitFor();
  const shown = await page.locator("#pictures canvas").evaluateAll((all) => new Set(all.map((one) => one.toDataURL())).size);
  assert.equal(shown, 24);
  await page.click("#pictures a[title='Level 30']");
  await waitForText(figure(page, "#figures", "Level seed"), /^30$/);
  assert.equal(new URL(page.url()).search, "?game=maze&mode=hard&level=30");
});

test("the form selects other levels and options", async () => {
  const page = await it.open(server.page("/gallery?game=maze&mode=hard&level=0"));
  await page.locator("#pictures canvas").first().waitFor();
  await page.selectOption("[name=game]", "caveflyer");
  await page.fill("[name=level]", "2147483640");
  await page.click("summary");
  await page.check("[name=restrict_themes]");
  await page.click("text=Show");
  await page.waitForURL("**level=2147483640**");
  await page.waitForFunction(() => document.querySelectorAll("#pictures canvas").length === 7);
  assert.equal(new URL(page.url()).searchParams.get("restrict_themes"), "true");
  assert.equal(await page.locator("#following").isVisible(), false);
});

test("levels are shown whole, and played as usual", async () => {
  const page = await it.open(server.page("/gallery?game=coinrun&mode=easy&level=0"));
  const first = page.locator("#pictures canvas").first();
  await first.waitFor();
  const seen = await first.evaluate((canvas) => canvas.toDataURL());
  await page.check("[name=whole]");
  await page.click("text=Show");
  await page.waitForURL("**whole=true**");
  await first.waitFor();
  assert.notEqual(await first.evaluate((canvas) => canvas.toDataURL()), seen);
  assert.equal(await page.isChecked("[name=whole]"), true);
  await page.click("#following");
  await page.waitForURL("**level=24**whole=true**");
  await page.click("#pictures a[title='Level 30']");
  await waitForText(figure(page, "#figures", "Level seed"), /^30$/);
  assert.equal(new URL(page.url()).search, "?game=coinrun&mode=easy&level=30");
});
