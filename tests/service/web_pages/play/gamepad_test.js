// Gamepads on the play page. The browser's gamepads are replaced, since a test has no device.

import assert from "node:assert/strict";
import { EventEmitter, once } from "node:events";
import { after, before, test } from "node:test";
import { decodeMessages } from "../bridge_messages.js";
import { figure, waitForText, withBrowser } from "../browser.js";
import { Server } from "../server.js";

const ACTIONS = { "RIGHT": 7, "LEFT+UP": 2, "D": 9, "NONE": 4, "RIGHT+DOWN": 6 };
const [LOWEST, START, BACK, CROSS_DOWN, CROSS_RIGHT] = [0, 9, 8, 13, 15];

const it = withBrowser();
let server;
before(async () => { server = await Server.start(); });
after(async () => assert.equal(await server.stop(), 0));

// Opens a level with a gamepad. `set(axes, ...buttons)` moves its stick and presses these buttons only.
async function openWithGamepad() {
  const context = await it.browser.newContext({ viewport: { width: 1280, height: 800 } });
  await context.addInitScript(() => {
    const gamepad = { connected: true, axes: [0, 0, 0, 0], buttons: Array.from({ length: 17 }, () => ({ pressed: false })) };
    navigator.getGamepads = () => [null, gamepad];
    globalThis.setGamepad = (axes, pressed) => {
      gamepad.axes = [...axes, 0, 0];
      gamepad.buttons.forEach((button, i) => { button.pressed = pressed.includes(i); });
    };
  });
  const page = await context.newPage();
  page.on("pageerror", (error) => it.errors.push(error.stack));
  const steps = new EventEmitter();
  await decodeMessages(page, server, {
    onSent: ({ message: { request } }) => request?.case === "step" && steps.emit(String(request.value.actions[0])),
  });
  await page.goto(server.page("/play?game=maze&mode=easy&level=5"));
  await waitForText(page.locator("#message"), "Press an arrow key to begin.");
  await page.evaluate(() => dispatchEvent(new Event("gamepadconnected")));
  const set = (axes, ...buttons) => page.evaluate(([stick, pressed]) => setGamepad(stick, pressed), [axes, buttons]);
  const asked = (name) => once(steps, String(ACTIONS[name]));
  return { page, set, asked };
}

test("stick and cross move, other buttons are the game's keys, and a press begins the level", async () => {
  const { page, set, asked } = await openWithGamepad();
  await waitForText(page.locator("#notices"), "Gamepad: stick or cross to move");
  assert.equal(await figure(page, "#figures", "Step").textContent(), "0");
  for (const [name, axes, ...buttons] of [
    ["RIGHT", [0.9, 0.2]], ["LEFT+UP", [-0.7, -0.7]], ["NONE", [0.3, -0.3]], ["RIGHT+DOWN", [0, 0], CROSS_DOWN, CROSS_RIGHT], ["D", [0, 0], LOWEST],
  ]) {
    await Promise.all([asked(name), set(axes, ...buttons)]);
  }
  await waitForText(page.locator("#pause"), "Pause");
});

test("Start pauses and resumes once per press, Back restarts", async () => {
  const { page, set, asked } = await openWithGamepad();
  await Promise.all([asked("RIGHT"), set([1, 0])]);
  await set([0, 0], START);
  await waitForText(page.locator("#pause"), "Resume");
  await page.evaluate(() => new Promise((resolve) => { requestAnimationFrame(() => requestAnimationFrame(resolve)); }));
  assert.match(await page.locator("#pause").textContent(), /^Resume/);
  await set([0, 0]);
  await page.evaluate(() => new Promise((resolve) => { requestAnimationFrame(() => requestAnimationFrame(resolve)); }));
  await set([0, 0], START);
  await waitForText(page.locator("#pause"), "Pause");
  await set([0, 0], BACK);
  await waitForText(page.locator("#pause"), "Begin");
  await waitForText(figure(page, "#figures", "Step"), /^0$/);
});
