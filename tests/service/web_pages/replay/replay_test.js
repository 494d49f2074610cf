// The replay page: a play is saved, loaded, scrubbed in both directions, and compared.

import assert from "node:assert/strict";
import { readFile, readdir, writeFile } from "node:fs/promises";
import { join } from "node:path";
import { test } from "node:test";
import { figure, picture, waitForPicture, waitForText, withBrowser } from "../browser.js";
import { COINRUN_1000, COINRUN_1000_PATH, COINRUN_1000_STEPS, playKeys } from "../playing.js";
import { withFolder, withServer } from "../server.js";

const GOLDEN = join(import.meta.dirname, "../../../conformance/golden");

const it = withBrowser();
const server = withServer();
const folder = withFolder();
const trace = join(folder, "coin.trace");  // of a play
let pictures;   // frames of the play, by step

function row(page, number) {
  return waitForText(figure(page, "#figures", "Step"), new RegExp(`^${number} of ${COINRUN_1000_STEPS}$`));
}

// Moves the slider as a pointer or a key does.
async function seek(page, number) {
  await page.locator("#row").fill(String(number));
  await row(page, number);
}

test("the replay page plays a play forward and backward", async () => {
  const page = await it.open(server.page(COINRUN_1000_PATH));
  await waitForText(figure(page, "#figures", "Step"), /^0$/);
  pictures = [await picture(page, "#human")];
  await playKeys(page, COINRUN_1000.slice(0, 2));
  await waitForPicture(page, "#human", (shown) => shown !== pictures[0]);
  pictures[3] = await picture(page, "#human");
  await page.reload();
  await playKeys(page, COINRUN_1000);
  await page.locator(`#human[aria-label*="step ${COINRUN_1000_STEPS}, score 10"]`).waitFor();
  pictures[COINRUN_1000_STEPS] = await picture(page, "#human");
  assert.notEqual(pictures[COINRUN_1000_STEPS], pictures[0]);
  const download = page.waitForEvent("download");
  await page.click("#save");
  await (await download).saveAs(trace);

  await page.click("#replay");
  await page.waitForURL("**/replay");
  await row(page, 0);
  assert.equal(await page.locator("#verdict").textContent(), "Identical to the recording");
  const controls = await page.locator("#run").boundingBox();
  assert(controls.y + controls.height <= page.viewportSize().height, "the controls are visible without scrolling");
  await waitForPicture(page, "#human", (shown) => shown === pictures[0]);
  await seek(page, 3);
  await waitForPicture(page, "#human", (shown) => shown === pictures[3]);
  await seek(page, COINRUN_1000_STEPS);
  assert.equal(await figure(page, "#figures", "Score").textContent(), "10");
  assert.equal(await figure(page, "#figures", "Reward").textContent(), "10");
  assert.equal(await page.getAttribute("#human", "aria-label"), `step ${COINRUN_1000_STEPS}, score 10, as people see it`);
  assert.match(await figure(page, "#figures", "Fingerprint").textContent(), /^[0-9a-f]{16}$/);
  assert.equal(await figure(page, "#figures", "Episode").textContent(), "complete");
  await waitForPicture(page, "#human", (shown) => shown === pictures[COINRUN_1000_STEPS]);
  await seek(page, 3);
  await waitForPicture(page, "#human", (shown) => shown === pictures[3]);
  await page.keyboard.press(",");
  await row(page, 2);
  await page.keyboard.press(".");
  await row(page, 3);
  await waitForPicture(page, "#human", (shown) => shown === pictures[3]);
  await page.click("#first");
  await row(page, 0);
  await waitForPicture(page, "#human", (shown) => shown === pictures[0]);
});

test("a saved file is loaded, survives a reload, plays to its end, and is saved unchanged", async () => {
  const page = await it.open(server.page("/replay"));
  await page.setInputFiles("#file", trace);
  await row(page, 0);
  assert.equal(await page.locator("#name").textContent(), "coin.trace");
  await page.reload();
  await row(page, 0);
  await page.click("#run");
  await row(page, COINRUN_1000_STEPS);
  await waitForText(page.locator("#run"), "Play");
  const download = page.waitForEvent("download");
  await page.click("#save");
  const again = join(folder, "again.trace");
  await (await download).saveAs(again);
  assert.deepEqual(await readFile(again), await readFile(trace));
});

test("the end of an episode and the start of the next one are frames of their own", async () => {
  const page = await it.open(server.page(COINRUN_1000_PATH));
  await playKeys(page, COINRUN_1000);
  await waitForText(page.locator("#message"), "Level complete");
  await page.keyboard.press(".");
  await waitForText(figure(page, "#figures", "Step"), /^0$/);
  await page.keyboard.press(".");
  await waitForText(figure(page, "#figures", "Step"), /^1$/);
  await page.click("#replay");
  const step = figure(page, "#figures", "Step");
  const episode = figure(page, "#figures", "Episode");
  const steps = COINRUN_1000_STEPS + 1;
  await waitForText(step, `0 of ${steps}`);
  await page.click("#last");
  await waitForText(step, `${steps} of ${steps}`);
  await waitForText(episode, "running");
  await page.click("#back");
  await waitForText(step, `${COINRUN_1000_STEPS} of ${steps}`);
  await waitForText(episode, "start");
  await waitForPicture(page, "#human", (shown) => shown === pictures[0]);
  await page.click("#back");
  await waitForText(episode, "complete");
  await waitForText(step, `${COINRUN_1000_STEPS} of ${steps}`);
  await waitForPicture(page, "#human", (shown) => shown === pictures[COINRUN_1000_STEPS]);
});

test("a diverging recording is reported by its row", async () => {
  const bytes = await readFile(trace);
  const headerBytes = bytes.indexOf("\n") + 1;
  const header = JSON.parse(bytes.subarray(0, headerBytes).toString());
  assert.equal(header.arrays[1][0], "reward");
  // A reward of 1.0 in row 5.
  bytes.writeFloatLE(1, headerBytes + header.steps + 5 * 4);
  const changed = join(folder, "changed.trace");
  await writeFile(changed, bytes);
  const page = await it.open(server.page("/replay"));
  await page.setInputFiles("#file", changed);
  await waitForText(page.locator("#verdict"), "Differs at step 5: reward is 0, was 1");
});

test("recordings of every game are replayed bit for bit", async () => {
  const page = await it.open(server.page("/replay"));
  const names = (await readdir(GOLDEN)).filter((name) => name.endsWith(".trace"));
  assert(names.length >= 16);
  for (const name of names) {
    await page.setInputFiles("#file", join(GOLDEN, name));
    await waitForText(page.locator("#name"), name);
    assert.equal(await page.locator("#verdict").textContent(), "Identical to the recording", name);
  }
});

test("an invalid trace is rejected, and the page continues", async () => {
  const page = await it.open(server.page("/replay"));
  await page.setInputFiles("#file", { name: "no.trace", mimeType: "", buffer: Buffer.from("no trace\n") });
  const problem = page.locator("#notices .bad");
  await waitForText(problem, "The file is not a trace: its first line is not JSON.");
  await page.click("#notices .bad button");
  await problem.waitFor({ state: "detached" });
  await page.setInputFiles("#file", { name: "no.trace", mimeType: "", buffer: Buffer.from("no trace\n") });
  await problem.waitFor();
  await page.setInputFiles("#file", trace);
  await row(page, 0);
  assert.equal(await problem.count(), 0, "an error disappears when another file is opened");
});
