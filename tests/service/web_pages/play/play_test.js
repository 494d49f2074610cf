// The play page, with real key events.

import assert from "node:assert/strict";
import { execFile } from "node:child_process";
import { EventEmitter, once } from "node:events";
import { join } from "node:path";
import { test } from "node:test";
import { promisify } from "node:util";
import { decodeMessages } from "../bridge_messages.js";
import { figure, picture, waitForPicture, waitForText, withBrowser } from "../browser.js";
import { COINRUN_1000, COINRUN_1000_PATH, COINRUN_1000_STEPS, playKeys } from "../playing.js";
import { withFolder, withServer } from "../server.js";

// Action numbers of the catalog.
const ACTIONS = { LEFT: 1, "LEFT+UP": 2, none: 4, "RIGHT+DOWN": 6, RIGHT: 7, "RIGHT+UP": 8, D: 9 };

const it = withBrowser();
const server = withServer();
const folder = withFolder();

test("recorded keys reach the coin, and procgen-conformance replays the trace bit for bit", async () => {
  const page = await it.open(server.page(COINRUN_1000_PATH));
  await playKeys(page, COINRUN_1000);
  await waitForText(page.locator("#message"), `Level complete: score 10 in ${COINRUN_1000_STEPS} steps`);
  assert.equal(await figure(page, "#figures", "Score").textContent(), "10");
  assert.equal(await figure(page, "#figures", "Level seed").textContent(), "1000");

  const download = page.waitForEvent("download");
  await page.click("#save");
  const file = await download;
  assert.match(file.suggestedFilename(), /^coinrun.*1000.*\.trace$/);
  await waitForText(page.locator("#notices"), /fingerprint [0-9a-f]{16}/);
  const path = join(folder, "played.trace");
  await file.saveAs(path);
  const { stdout } = await promisify(execFile)(process.env.PROCGEN_CONFORMANCE, [path]);
  assert.match(stdout, /^1 passed, 0 failed, 0 skipped$/m);
});

test("a level starts with the first key and runs at 15 steps a second until it is paused", async () => {
  const page = await it.open(server.page("/play?game=bigfish&mode=hard&level=7"));
  const step = figure(page, "#figures", "Step");
  await waitForText(page.locator("#message"), "Press an arrow key to begin.");
  assert.equal(await step.textContent(), "0");
  await page.keyboard.press("ArrowLeft");
  await waitForText(step, /^[1-9]/);
  await page.keyboard.press("p");
  await waitForText(page.locator("#pause"), "Resume");
  const paused = Number(await step.textContent());
  await page.keyboard.press(".");
  await page.waitForFunction(([before]) =>
    Number(document.querySelectorAll("#figures dd")[1].textContent) > before, [paused]);
});

test("the space bar begins, pauses and resumes a level, and never scrolls the page", async () => {
  const page = await it.open(server.page("/play?game=bigfish&mode=hard&level=7"), { viewport: { width: 1280, height: 500 } });
  await waitForText(page.locator("#message"), "Press an arrow key to begin.");
  for (const label of ["Pause", "Resume", "Pause"]) {
    await page.keyboard.press("Space");
    await waitForText(page.locator("#pause"), label);
  }
  assert.equal(await page.evaluate(() => scrollY), 0);
  await waitForText(figure(page, "#figures", "Step"), /^[1-9]/);
});

test("restart repeats the level, the next level has the next seed, and the URL follows", async () => {
  const page = await it.open(server.page("/play?game=maze&mode=easy&level=41&use_backgrounds=false"));
  const seed = figure(page, "#figures", "Level seed");
  await waitForText(seed, /^41$/);
  assert.equal(await page.locator("[name=use_backgrounds]").isChecked(), false);
  const start = await picture(page, "#human");
  await page.keyboard.press(".");
  await waitForText(figure(page, "#figures", "Step"), /^1$/);
  assert.equal(await page.getAttribute("#human", "aria-label"), "maze, level 41, step 1, score 0, as people see it");
  await page.keyboard.press("r");
  await waitForText(figure(page, "#figures", "Step"), /^0$/);
  await waitForPicture(page, "#human", (shown) => shown === start);
  await page.keyboard.press("n");
  await waitForText(seed, /^42$/);
  assert.equal(new URL(page.url()).search, "?game=maze&mode=easy&level=42&use_backgrounds=false");
  await waitForPicture(page, "#human", (shown) => shown !== start);
  const next = await picture(page, "#human");
  const again = await it.open(page.url());
  await waitForText(figure(again, "#figures", "Level seed"), /^42$/);
  await waitForPicture(again, "#human", (shown) => shown === next);
});

test("the form chooses game, mode, level and options", async () => {
  const page = await it.open(server.page("/play"));
  await waitForText(figure(page, "#figures", "Level seed"), /^0$/);
  await page.selectOption("[name=game]", "heist");
  await page.selectOption("[name=mode]", "memory");
  await page.fill("[name=level]", "123");
  await page.click("summary");
  await page.check("[name=use_monochrome_assets]");
  await page.click("text=Play this level");
  await waitForText(figure(page, "#figures", "Level seed"), /^123$/);
  assert.equal(new URL(page.url()).search, "?game=heist&mode=memory&level=123&use_monochrome_assets=true");
  assert.match(await page.title(), /^heist, level 123/);
});

test("the end of a level is shown until the player starts the next level or the same one", async () => {
  const page = await it.open(server.page(COINRUN_1000_PATH));
  const step = figure(page, "#figures", "Step");
  await waitForText(step, /^0$/);
  const start = await picture(page, "#human");
  await playKeys(page, COINRUN_1000);
  const atEnd = `coinrun, level 1000, step ${COINRUN_1000_STEPS}, score 10, as people see it`;
  await page.locator(`#human[aria-label="${atEnd}"]`).waitFor();
  const end = await picture(page, "#human");
  assert.notEqual(end, start);
  await waitForText(page.locator("#pause"), "Next level");

  // A step leads to the start of the next episode.
  await page.keyboard.press(".");
  await waitForPicture(page, "#human", (shown) => shown === start);
  await waitForText(step, /^0$/);
  await page.keyboard.press(".");
  await waitForText(step, /^1$/);

  await page.keyboard.press("r");
  await playKeys(page, COINRUN_1000);
  await page.locator(`#human[aria-label="${atEnd}"]`).waitFor();
  await waitForPicture(page, "#human", (shown) => shown === end);
  await page.keyboard.press("Enter");
  await waitForText(figure(page, "#figures", "Level seed"), /^1001$/);
  await waitForText(page.locator("#pause"), "Begin");
});

// Opens a level and records its steps. `asked(action)` waits for a step with this action.
async function openRecorded(options) {
  const page = await it.open("about:blank", options);
  const steps = new EventEmitter();
  await decodeMessages(page, server, {
    onSent: ({ message: { request } }) => request?.case === "step" && steps.emit(String(request.value.actions[0])),
  });
  await page.goto(server.page("/play?game=maze&mode=easy&level=5"));
  await waitForText(page.locator("#message"), /(Press|Touch) an arrow/);
  return { page, asked: (action) => once(steps, String(ACTIONS[action])) };
}

test("the newest held key wins, combined with compatible keys", async () => {
  const { page, asked } = await openRecorded();
  const change = (what, key, action) => Promise.all([asked(action), page.keyboard[what](key)]);
  await change("down", "ArrowRight", "RIGHT");
  await change("down", "d", "D");
  await change("up", "d", "RIGHT");
  await change("down", "ArrowUp", "RIGHT+UP");
  await change("down", "ArrowLeft", "LEFT+UP");
  await change("up", "ArrowUp", "LEFT");
});

test("while keys that shoot and keys that move are held, steps do either in turn", async () => {
  const { page, asked } = await openRecorded();
  await page.keyboard.down("d");
  await page.keyboard.down("ArrowRight");
  for (const action of ["RIGHT", "D", "RIGHT", "D"]) {
    await asked(action);
  }
  await Promise.all([asked("RIGHT+UP"), page.keyboard.down("ArrowUp")]);
  await asked("D");
});

test("touch buttons combine two fingers, and a sliding finger presses the buttons that it reaches", async () => {
  const { page, asked } = await openRecorded({ viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true });
  const session = await page.context().newCDPSession(page);
  const on = async (key, id) => {
    const { x, y, width, height } = await page.locator(`[data-key="${key}"]`).boundingBox();
    return { id, x: x + width / 2, y: y + height / 2 };
  };
  const touch = (type, touchPoints, action) =>
    Promise.all([asked(action), session.send("Input.dispatchTouchEvent", { type, touchPoints })]);
  await touch("touchStart", [await on("RIGHT", 1)], "RIGHT");
  await touch("touchStart", [await on("UP", 2)], "RIGHT+UP");
  await touch("touchMove", [await on("RIGHT", 1), await on("DOWN", 2)], "RIGHT+DOWN");
  await touch("touchMove", [await on("LEFT UP", 1), await on("DOWN", 2)], "LEFT+UP");
  await touch("touchEnd", [], "none");
  await waitForText(figure(page, "#figures", "Step"), /^[1-9]/);
});
