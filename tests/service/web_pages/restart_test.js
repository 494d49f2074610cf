// The server stops and restarts while pages are open.

import assert from "node:assert/strict";
import { test } from "node:test";
import { figure, waitForChange, waitForText, withBrowser } from "./browser.js";
import { Learner, Server } from "./server.js";

const FIRST = "#mosaic li:first-child canvas";
const it = withBrowser();

test("pages report a lost server and reconnect by themselves", async () => {
  let server = await Server.start();
  let learner = await Learner.start(server, "before", ["coinrun"], 4);
  const live = await it.open(server.page(), { viewport: { width: 390, height: 844 } });
  await live.locator(FIRST).waitFor();
  const play = await it.open(server.page("/play?game=maze&mode=easy&level=5"));
  await waitForText(play.locator("#message"), "Press an arrow key to begin.");
  await play.keyboard.press(".");
  await waitForText(figure(play, "#figures", "Step"), /^1$/);

  await learner.stop();
  assert.equal(await server.stop(), 0);
  for (const page of [live, play]) {
    await waitForText(page.locator(".link"), "Waiting for the server");
  }
  const size = await live.locator(".link").evaluate((state) => parseFloat(getComputedStyle(state).fontSize));
  assert(size >= 12, "a narrow window shows the state as text, not only by color");
  await waitForText(play.locator("#message"), "The connection was lost.");

  server = await Server.start(`--web_address=${new URL(server.web).host}`);
  learner = await Learner.start(server, "after", ["coinrun"], 4);
  for (const page of [live, play]) {
    await waitForText(page.locator(".link"), "Connected");
  }
  await waitForText(live.locator("#pool-name"), "pools/after");
  await waitForChange(live, FIRST);
  await waitForText(figure(play, "#figures", "Step"), /^0$/);
  await play.keyboard.press(".");
  await waitForText(figure(play, "#figures", "Step"), /^1$/);
  await learner.stop();
  assert.equal(await server.stop(), 0);
});
