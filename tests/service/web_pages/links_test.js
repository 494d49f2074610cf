// Links to what does not exist say so, and show nothing else.

import assert from "node:assert/strict";
import { before, test } from "node:test";
import { waitForText, withBrowser } from "./browser.js";
import { Learner, withServer } from "./server.js";

const it = withBrowser();
const server = withServer();
before(() => Learner.start(server, "running", ["coinrun"], 4));

// Queries, what is said, and a link that is offered.
const WRONG = [
  ["game=pong&mode=easy&level=3", "There is no game “pong”.", "maze"],
  ["game=coinrun&mode=memory&level=3", "coinrun has no mode “memory”.", "hard"],
  ["game=maze&mode=easy&level=-4", "There is no level “-4”: levels are 0 to 2147483646.", "Level 0"],
  ["game=coinrun&mode=exploration&level=3", "coinrun, exploration has no level “3”, only level", "Level"],
  ["game=maze&mode=easy&level=3&use_backgrounds=no", "The option use_backgrounds is “no”, allowed: true or false.", "Without use_backgrounds"],
  ["game=maze&mode=easy&level=3&speed=2", "There is no option “speed”.", "Without speed"],
  ["game=coinrun&mode=easy&level=3&debug_mode=x", "The option debug_mode is “x”, allowed: integers from", "Without debug_mode"],
  ["game=maze&mode=easy&level=3&variant=coin_random", "The option variant is “coin_random”, allowed: cheese_corner, two_objects.", "Without variant"],
  ["game=heist&mode=easy&level=3&variant=coin_random", "The option variant is “coin_random”, allowed: none in heist.", "Without variant"],
];

for (const path of ["/play", "/gallery"]) {
  test(`${path} reports a link to a level that does not exist`, async () => {
    const page = await it.open(server.page(path));
    for (const [query, text, offer] of WRONG) {
      await page.goto(server.page(`${path}?${query}`));
      await waitForText(page.locator("#wrong"), text);
      assert.equal(new URL(page.url()).search.slice(1), query, "the URL stays");
      assert.equal(await page.locator(path === "/play" ? "#stage" : "#levels").isVisible(), false);
      const offered = page.locator("#wrong a", { hasText: offer }).first();
      await offered.click();
      await page.locator(path === "/play" ? "#stage" : "#levels").waitFor();
      assert.equal(await page.locator("#wrong").isVisible(), false);
    }
  });
}

test("a link to a pool that does not exist shows no other pool", async () => {
  const page = await it.open(server.page("/?pool=pools%2F99"));
  await waitForText(page.locator("#missing"), "There is no pool pools/99");
  assert.equal(await page.locator("#pool").isVisible(), false);
  assert.equal(new URL(page.url()).searchParams.get("pool"), "pools/99");
  await page.click("#pools a:has-text('pools/running')");
  await waitForText(page.locator("#pool-name"), "pools/running");
  assert.equal(await page.locator("#missing").isVisible(), false);
});

test("a link to an environment enlarges it, and the URL follows", async () => {
  const page = await it.open(server.page("/?pool=pools%2Frunning&environment=2"));
  await waitForText(page.locator("#large-title"), "pools/running, environment 2");
  await page.keyboard.press("ArrowRight");
  await waitForText(page.locator("#large-title"), "environment 3");
  assert.equal(new URL(page.url()).search, "?pool=pools%2Frunning&environment=3");
  await page.reload();
  await waitForText(page.locator("#large-title"), "environment 3");
  await page.keyboard.press("Escape");
  await page.locator("#large").waitFor({ state: "hidden" });
  assert.equal(new URL(page.url()).search, "?pool=pools%2Frunning");
  await page.click("#mosaic li:nth-child(2) button");
  assert.equal(new URL(page.url()).search, "?pool=pools%2Frunning&environment=1");
  await page.click("#close");
  assert.equal(new URL(page.url()).search, "?pool=pools%2Frunning");
});

test("a link to an environment that does not exist is reported", async () => {
  for (const wrong of ["4", "-1", "first"]) {
    const page = await it.open(server.page(`/?pool=pools%2Frunning&environment=${wrong}`));
    await waitForText(page.locator("#notices .bad"), `pools/running has no environment “${wrong}”: environments are 0 to 3.`);
    assert.equal(await page.locator("#large").isVisible(), false);
  }
});
