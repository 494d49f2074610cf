// The URL of the live view has what is compared and how it is drawn.

import assert from "node:assert/strict";
import { before, test } from "node:test";
import { waitForText, withBrowser } from "../browser.js";
import { Learner, Pool, withServer } from "../server.js";

const it = withBrowser();
const server = withServer();
before(async () => {
  await Learner.start(server, "one", ["coinrun"], 16);
  await Learner.start(server, "two", ["coinrun"], 16);
});

test("compared pools and the settings of plots are in the URL, and there after a reload", async () => {
  const page = await it.open(server.page("/?pool=pools/one"));
  await page.getByLabel("Compare pools/two").check();
  await page.selectOption("#span", "3600");
  await page.selectOption("#x", { label: "Over steps" });
  await page.selectOption("#smoothing", "0.9");
  await page.check("#normalised");
  const query = new URL(page.url()).searchParams;
  assert.deepEqual(Object.fromEntries(query),
    { pool: "pools/one", compare: "pools/two", span: "3600", x: "steps", smoothing: "0.9", normalised: "true" });
  const again = await it.open(page.url());
  await waitForText(again.locator("#pool-name"), "pools/one");
  await waitForText(again.locator("#plots .number").first(), /pools\/one .*pools\/two /);
  assert(await again.getByLabel("Compare pools/two").isChecked());
  for (const [id, value] of [["span", "3600"], ["x", "steps"], ["smoothing", "0.9"]]) {
    assert.equal(await again.inputValue(`#${id}`), value);
  }
  assert(await again.isChecked("#normalised"));
  await again.getByLabel("Compare pools/two").uncheck();
  await again.selectOption("#span", "600");
  const left = new URL(again.url()).searchParams;
  assert(!left.has("compare") && !left.has("span"));
});

test("the return comes first, with the means of a random agent and of the reference learner", async () => {
  const page = await it.open(server.page("/?pool=pools/one"));
  const first = page.locator("#plots figure").first();
  await waitForText(first.locator("h3"), "Mean return");
  await waitForText(first.locator(".number"), /random agent 2\.77.*PPO, 25 million steps 8\.65/);
  const [high, other] = await page.locator("#plots .drawing").evaluateAll((all) => all.map((one) => one.getBoundingClientRect().height));
  assert(high > 1.4 * other);
});

test("names and labels of pools are shown, and found by the filter", async () => {
  const pool = await Pool.open(server, ["maze"], 1, { pool_id: "named", name: "maze-seed3", labels: { seed: "3", run: "baseline" } });
  const page = await it.open(server.page("/?pool=pools/named"));
  await waitForText(page.locator("#pool-name"), "maze-seed3");
  await waitForText(page.locator("#pool-labels"), /run=baselineseed=3/);
  await waitForText(page.locator("#pool-about"), "pools/named");
  await page.fill("#pool-filter", "seed=3");
  await waitForText(page.locator("#pools-count"), "1 of 3 pools");
  assert.equal(await page.locator("#pools a").textContent(), "maze-seed3");
  await pool.close();
});
