// The table of pools.

import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { once } from "node:events";
import { after, before, test } from "node:test";
import { waitForText, withBrowser } from "../browser.js";
import { Learner, Pool, Server } from "../server.js";

const POOL_COUNT = 43;
// Makes the other pools, prints a line, and keeps them until its input ends.
const MAKE_POOLS = `
import sys
import procgen_client
client = procgen_client.Client(sys.argv[1])
pools = [
    client.create_pool("maze" if i % 2 else "heist", 1 + i % 5, distribution_mode="easy", pool_id=f"idle-{i}")
    for i in range(1, ${POOL_COUNT})
]
print("ready", flush=True)
sys.stdin.readline()
`;
const it = withBrowser();
let server;
let learner;
let maker;
before(async () => {
  server = await Server.start();
  learner = await Learner.start(server, "trained", ["coinrun"], 4);
  maker = spawn(process.env.PROCGEN_PYTHON, ["-c", MAKE_POOLS, server.address], { stdio: ["pipe", "pipe", "inherit"] });
  await once(maker.stdout, "data");
});
after(async () => {
  const exited = once(maker, "exit");
  maker.stdin.end();
  await exited;
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
  await waitForText(row(page, "pools/trained"), "running");
  await page.waitForFunction(() => document.querySelector("#pools a").textContent === "pools/trained");
  await waitForText(row(page, "pools/idle-7"), "never stepped");
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

test("a pool leaves the table when its program closes it", async () => {
  const pool = await Pool.open(server, ["maze"], 1, { pool_id: "short" });
  const page = await openPools();
  await row(page, "pools/short").waitFor();
  await pool.close();
  await row(page, "pools/short").waitFor({ state: "detached" });
});
