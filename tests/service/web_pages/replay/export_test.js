// Images and videos of a replay, decoded again and compared with what the page shows.

import assert from "node:assert/strict";
import { readFile, writeFile } from "node:fs/promises";
import { join } from "node:path";
import { before, test } from "node:test";
import { figure, picture, waitForText, withBrowser } from "../browser.js";
import { decode, differenceFrom } from "../saved_images.js";
import { Pool, withFolder, withServer } from "../server.js";

const STEPS = 40;
const STEPS_PER_SECOND = 15;
const SHOWN = 12;

const it = withBrowser();
const server = withServer();
const folder = withFolder();
let pool;
before(async () => {
  pool = await Pool.open(server, ["starpilot"], 1);
  for (let step = 1; step < STEPS; step += 1) {
    await pool.step([9]);
  }
  await pool.step([-1]);
});

async function openExport(options = {}) {
  const page = await it.open(server.page(`/replay?pool=${encodeURIComponent(pool.name)}&environment=0&step=${SHOWN}`), options);
  await waitForText(figure(page, "#figures", "Step"), `${SHOWN} of ${STEPS}`);
  await page.click("#open-export");
  return page;
}

async function save(page, button) {
  const download = page.waitForEvent("download");
  await page.click(button);
  const file = await download;
  await waitForText(page.locator("#export-state"), `Saved ${file.suggestedFilename()}.`);
  return { name: file.suggestedFilename(), content: (await readFile(await file.path())).toString("base64") };
}

test("the image of a step has the chosen view", async () => {
  const page = await openExport();
  assert.match(await page.locator("#export-image").textContent(), new RegExp(`step ${SHOWN}$`));
  const human = await save(page, "#export-image");
  assert.match(human.name, new RegExp(`^starpilot\\.easy\\.\\d+\\.human\\.step-${SHOWN}\\.png$`));
  assert.deepEqual(await differenceFrom(page, "#human", human.content), { size: 512, difference: 0 });
  await page.selectOption("#export-view", "agent");
  const agent = await save(page, "#export-image");
  assert.match(agent.name, new RegExp(`\\.agent\\.step-${SHOWN}\\.png$`));
  assert.deepEqual(await differenceFrom(page, "#agent", agent.content), { size: 512, difference: 0 });
});

test("a video has all frames, in the chosen view and speed", async () => {
  const page = await openExport();
  for (const [view, speed] of [["human", 1], ["agent", 4]]) {
    await page.keyboard.press("Escape");
    await page.selectOption("#speed", String(speed));
    await page.click("#open-export");
    await page.selectOption("#export-view", view);
    const video = await save(page, "#export-video");
    assert.match(video.name, new RegExp(`\\.${view}\\.mp4$`));
    const perSecond = STEPS_PER_SECOND * speed;
    const shown = await decode(it, video.content, (SHOWN + 0.5) / perSecond);
    assert.deepEqual([shown.width, shown.height], [512, 512]);
    assert(Math.abs(shown.duration - (STEPS + 1) / perSecond) < 0.05, `${shown.duration} s`);
    const { difference } = await differenceFrom(page, `#${view}`, shown.content);
    assert(difference < 4, `${view}: the frame differs by ${difference}`);
    const other = await decode(it, video.content, (SHOWN + 12.5) / perSecond);
    const { difference: further } = await differenceFrom(page, `#${view}`, other.content);
    assert(further > 2 * difference, `${view}: another frame differs by ${further}, this one by ${difference}`);
  }
  await page.keyboard.press("Escape");
  await waitForText(figure(page, "#figures", "Step"), `${SHOWN} of ${STEPS}`);
});

test("a video ends with the last frame of the episode, not with the next start", async () => {
  const page = await openExport();
  const video = await save(page, "#export-video");
  await page.keyboard.press("Escape");
  // The last step, action -1, ends the episode without a move.
  await page.locator("#row").fill(String(STEPS - 1));
  await waitForText(figure(page, "#figures", "Step"), `${STEPS - 1} of ${STEPS}`);
  const differenceAt = async (step) => {
    const { content } = await decode(it, video.content, (step + 0.5) / STEPS_PER_SECOND);
    return (await differenceFrom(page, "#human", content)).difference;
  };
  const difference = await differenceAt(STEPS);
  const further = await differenceAt(0);
  assert(further > 4 * difference, `a start differs by ${further}, the last frame by ${difference}`);
});

test("a web page has all frames of the agent's view and a player, and needs no server", async () => {
  const page = await openExport();
  const saved = await save(page, "#export-page");
  assert.match(saved.name, /\.html$/);
  const bytes = Buffer.from(saved.content, "base64");
  assert(bytes.length < 2_000_000, `${bytes.length} bytes`);
  const path = join(folder, saved.name);
  await writeFile(path, bytes);
  const context = await it.browser.newContext({ offline: true });
  const alone = await it.openIn(context, `file://${path}`);
  await waitForText(alone.locator("[role=status]"), "Step 0");
  await alone.locator("input").fill(String(SHOWN));
  await waitForText(alone.locator("[role=status]"), `Step ${SHOWN}, `);
  await page.keyboard.press("Escape");
  assert.equal(await picture(alone, "canvas"), await picture(page, "#agent"));
  await alone.click("button");
  await waitForText(alone.locator("button"), "Pause");
  await waitForText(alone.locator("[role=status]"), `Step ${STEPS}, `);
  await waitForText(alone.locator("button"), "Play");
});

test("a video is cancelled by the button and by closing the dialog", async () => {
  const page = await openExport();
  const downloads = [];
  page.on("download", (download) => downloads.push(download));
  const clickBoth = (id) => page.evaluate((name) => {
    document.getElementById("export-video").click();
    document.getElementById(name).click();
  }, id);
  const isIdle = () => page.waitForFunction(() => !document.getElementById("export-video").disabled);
  await clickBoth("export-cancel");
  await waitForText(page.locator("#export-state"), "Cancelled.");
  await isIdle();
  await clickBoth("export-close");
  await isIdle();
  assert.deepEqual(downloads, []);
});

test("a browser without video encoding says why, and still saves images", async () => {
  for (const [isSecure, text] of [[true, "does not encode videos."], [false, "encodes videos only on HTTPS and localhost."]]) {
    const context = await it.browser.newContext();
    await context.addInitScript((value) => {
      delete globalThis.VideoEncoder;
      Object.defineProperty(globalThis, "isSecureContext", { value });
    }, isSecure);
    const page = await it.openIn(context, server.page(`/replay?pool=${encodeURIComponent(pool.name)}&environment=0&step=${SHOWN}`));
    await waitForText(figure(page, "#figures", "Step"), `${SHOWN} of ${STEPS}`);
    await page.click("#open-export");
    await waitForText(page.locator("#export-about"), `This browser ${text}`);
    assert.equal(await page.locator("#export-video").isEnabled(), false);
    await save(page, "#export-image");
  }
});
