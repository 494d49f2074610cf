// The table of pools.

import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { connect, DistributionMode } from "../../../../clients/node/dist/index.js";
import { waitForText, withBrowser } from "../browser.js";
import { Learner, Server } from "../server.js";

const POOL_COUNT = 43;
const it = withBrowser();
let server;
let learner;
let client;
before(async () => {
  server = await Server.start();
  learner = await Learner.start(server, "trained", ["coinrun"], 4);
  client = await connect(server.address);
  for (let i = 1; i < POOL_COUNT; i += 1) {
    await client.createPool({ games: [i % 2 ? "maze" : "heist"], envCount: 1 + i % 5, options: { distributionMode: DistributionMode.EASY } },
      { poolId: `idle-${i}` });
  }
  await (await client.getPool("pools/idle-5")).renew(3600);
});
after(async () => {
  client.close();
  await learner.stop();
  assert.equal(await server.stop(), 0);
});

async function openPools(path = "/", options = {}) {
  const page = await it.open(server.page(path), options);
  await page.locator("#pools tr").first().waitFor();
  return page;
}

function names(page) {
  return page.locator("#pools a").allTextContents();
}

function row(page, name) {
  return page.locator("#pools tr", { has: page.getByRole("link", { name, exact: true }) });
}

test("a pool with a learner comes first, and each row shows its state", async () => {
  const page = await openPools();
  await waitForText(page.locator("#pools-count"), `${POOL_COUNT} pools`);
  await waitForText(row(page, "pools/trained"), "learner attached");
  await page.waitForFunction(() => document.querySelector("#pools a").textContent === "pools/trained");
  await waitForText(row(page, "pools/idle-7"), "never stepped");
  await waitForText(row(page, "pools/idle-5"), /59 min/);
  await page.waitForFunction(() => document.querySelector("#pools .sparkline polyline").getAttribute("points") !== "");
});

test("the filter finds pools by game and by state", async () => {
  const page = await openPools();
  await page.fill("#pool-filter", "heist never");
  await waitForText(page.locator("#pools-count"), `21 of ${POOL_COUNT} pools`);
  assert((await names(page)).every((name) => Number(name.split("-")[1]) % 2 === 0));
  await page.fill("#pool-filter", "pong");
  await waitForText(page.locator("#pools-none"), "No pool matches the filter.");
  await page.fill("#pool-filter", "");
  await waitForText(page.locator("#pools-count"), `${POOL_COUNT} pools`);
});

test("columns sort by number or in natural order, by keyboard", async () => {
  const page = await openPools();
  await page.locator("#pool-columns button:has-text('Pool')").focus();
  await page.keyboard.press("Enter");
  const sorted = await names(page);
  assert.deepEqual(sorted.slice(0, 3), ["pools/idle-1", "pools/idle-2", "pools/idle-3"]);
  assert.equal(sorted.at(-1), "pools/trained");
  await page.locator("#pool-columns button:has-text('Environments')").focus();
  await page.keyboard.press("Enter");
  const counts = (await page.locator("#pools td:nth-child(5)").allTextContents()).map(Number);
  assert.deepEqual(counts, [...counts].sort((a, b) => b - a));
});

test("the pool of the URL is scrolled into view, and so in a narrow window", async () => {
  for (const viewport of [{ width: 1280, height: 800 }, { width: 320, height: 640 }]) {
    const page = await openPools("/?pool=pools%2Fidle-3", { viewport });
    await waitForText(page.locator("#pool-name"), "pools/idle-3");
    const isVisible = await row(page, "pools/idle-3").evaluate((line) => {
      const [inner, outer] = [line, line.closest(".scroll")].map((one) => one.getBoundingClientRect());
      return inner.top >= outer.top && inner.bottom <= outer.bottom;
    });
    assert(isVisible, `${viewport.width} pixels`);
    assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), viewport.width);
    const list = await page.locator("#pool-list").boundingBox();
    assert(list.height <= viewport.height / 2, "the list leaves room for the pool");
  }
});

test("a pool is deleted after confirmation", async () => {
  const page = await openPools("/?pool=pools%2Fidle-9");
  await page.getByRole("button", { name: "Delete pools/idle-9", exact: true }).click();
  await waitForText(page.locator("#delete-title"), "Delete pools/idle-9?");
  await page.keyboard.press("Enter");
  await page.locator("#delete").waitFor({ state: "hidden" });
  assert.equal((await client.getPool("pools/idle-9")).name, "pools/idle-9", "Cancel has the focus");
  await page.getByRole("button", { name: "Delete pools/idle-9", exact: true }).click();
  await page.click("#delete-confirm");
  await page.locator("#delete").waitFor({ state: "hidden" });
  await row(page, "pools/idle-9").waitFor({ state: "detached" });
  assert.equal(new URL(page.url()).search, "");
  await assert.rejects(client.getPool("pools/idle-9"));
});

test("the error of a deletion is shown in its dialog", async () => {
  const page = await openPools();
  await page.getByRole("button", { name: "Delete pools/idle-11", exact: true }).click();
  await client.deletePool("pools/idle-11");
  await page.click("#delete-confirm");
  await waitForText(page.locator("#delete-problem"), /pools\/idle-11/);
  await page.click("#delete-cancel");
});
