// The server stops and restarts while pages are open.

import assert from "node:assert/strict";
import { test } from "node:test";
import { figure, waitForChange, waitForText, withBrowser } from "../browser.js";
import { Learner, Server } from "../server.js";

const FIRST = "#mosaic li:first-child canvas";
const it = withBrowser();

test("pages report a lost server and reconnect by themselves", async () => {
  let server = await Server.start();
  await Learner.start(server, "before", ["coinrun"], 4);
  const live = await it.open(server.page(), { viewport: { width: 390, height: 844 } });
  await live.locator(FIRST).waitFor();
  const play = await it.open(server.page("/play?game=maze&mode=easy&level=5"));
  await waitForText(play.locator("#message"), "Press an arrow key to begin.");
  await play.keyboard.press(".");
  await waitForText(figure(play, "#figures", "Step"), /^1$/);

  assert.equal(await server.stop(), 0);
  for (const page of [live, play]) {
    await waitForText(page.locator(".link"), "Waiting for the server");
  }
  const size = await live.locator(".link").evaluate((state) => parseFloat(getComputedStyle(state).fontSize));
  assert(size >= 12, "a narrow window shows the state as text, not only by color");
  await waitForText(play.locator("#message"), "The connection was lost.");

  server = await Server.start(`--web_address=${new URL(server.web).host}`);
  await Learner.start(server, "after", ["coinrun"], 4);
  for (const page of [live, play]) {
    await waitForText(page.locator(".link"), "Connected");
  }
  await waitForText(live.locator("#pool-name"), "pools/after");
  await waitForText(live.locator("#notices"), "pools/before was closed, and its history is gone.");
  await waitForText(live.locator("#notices"), "Reconnected to the server.");
  assert.equal(await live.locator("#notices", { hasText: "node-" }).count(), 0, "a single server is not reported as a lost node");
  await live.locator("#outage").waitFor({ state: "hidden" });
  await waitForChange(live, FIRST);
  await waitForText(figure(play, "#figures", "Step"), /^0$/);
  await play.keyboard.press(".");
  await waitForText(figure(play, "#figures", "Step"), /^1$/);
  assert.equal(await server.stop(), 0);
});

test("a play says that its server is silent, continues when it answers, and restarts when it is lost instead", async () => {
  let server = await Server.start();
  const page = await it.open(server.page("/play?game=maze&mode=easy&level=7"));
  await waitForText(page.locator("#message"), "Press an arrow key to begin.");
  server.process.kill("SIGSTOP");
  await page.keyboard.press("ArrowRight");
  await waitForText(page.locator("#outage"), /The server has sent nothing since \d\d:\d\d:\d\d/);
  server.process.kill("SIGCONT");
  await page.locator("#outage").waitFor({ state: "hidden" });
  await waitForText(figure(page, "#figures", "Step"), /[1-9]/);

  server.process.kill("SIGSTOP");
  await waitForText(page.locator("#outage"), "The server has sent nothing since");
  server.process.kill("SIGKILL");
  await waitForText(page.locator("#message"), "The connection was lost. The level restarts after reconnecting.");
  server = await Server.start(`--web_address=${new URL(server.web).host}`);
  await waitForText(figure(page, "#figures", "Step"), /^0$/);
  assert.equal(await server.stop(), 0);
});

test("while a server is dead or silent, what is shown is marked as outdated", async () => {
  const server = await Server.start();
  const learner = await Learner.start(server, "watched", ["coinrun"], 4);
  const page = await it.open(server.page());
  await page.locator(FIRST).waitFor();
  const rates = [figure(page, "#server", "Steps / s"), figure(page, "#pool-figures", "Steps / s")];
  const opacity = () => page.locator("#mosaic").evaluate((mosaic) => Number(getComputedStyle(mosaic).opacity));
  const expectOutdated = async (text) => {
    await waitForText(page.locator("#outage"), text);
    await waitForText(page.locator("#pool-state"), "unknown");
    for (const rate of rates) {
      assert.equal(await rate.textContent(), "–");
    }
    assert(await opacity() < 1);
  };
  await waitForText(rates[1], /[1-9]/);
  assert.equal(await opacity(), 1);

  server.process.kill("SIGSTOP");
  await expectOutdated("The server has sent nothing since");
  server.process.kill("SIGCONT");
  await waitForText(page.locator("#pool-state"), "running");
  await page.locator("#outage").waitFor({ state: "hidden" });
  assert.equal(await opacity(), 1);

  learner.abandon();
  server.process.kill("SIGKILL");
  await expectOutdated(/The connection was lost at \d\d:\d\d:\d\d/);
});
