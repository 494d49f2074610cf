// A replay leaves its page: as a program in Python, which this runs against the same server, and as a play that continues it.

import assert from "node:assert/strict";
import { execFile } from "node:child_process";
import { writeFile } from "node:fs/promises";
import { join } from "node:path";
import { test } from "node:test";
import { promisify } from "node:util";
import { figure, picture, waitForPicture, waitForText, withBrowser } from "../browser.js";
import { COINRUN_1000, COINRUN_1000_PATH, COINRUN_1000_STEPS, playKeys } from "../playing.js";
import { withFolder, withServer } from "../server.js";

const GOLDEN = join(import.meta.dirname, "../../../conformance/golden");

const it = withBrowser();
const server = withServer();
const folder = withFolder();

// Runs a program with the Python client, and returns the SHA-256 of its observation and its fingerprints.
async function runPython(program) {
  const path = join(folder, "copied.py");
  await writeFile(path, `${program}
import hashlib
print(hashlib.sha256(observation.tobytes()).hexdigest(), *(f"{value:016x}" for value in batch.fingerprints[batch.ended]))
`);
  const { stdout } = await promisify(execFile)(process.env.PROCGEN_PYTHON, [path]);
  const [digest, ...fingerprints] = stdout.trim().split("\n").at(-1).split(" ");
  return { digest, fingerprints };
}

// The SHA-256 of the agent's observation.
function observation(page) {
  return page.locator("#agent").evaluate(async (canvas) => {
    const pixels = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
    const digest = await crypto.subtle.digest("SHA-256", pixels.filter((_, i) => i % 4 !== 3));
    return [...new Uint8Array(digest)].map((byte) => byte.toString(16).padStart(2, "0")).join("");
  });
}

async function copied(page) {
  await page.context().grantPermissions(["clipboard-read", "clipboard-write"]);
  await page.click("#copy-python");
  await waitForText(page.locator("#notices"), "Copied a program");
  return page.evaluate(() => navigator.clipboard.readText());
}

// A replay of coinrun's level 1000 up to its coin.
async function openReplay() {
  const page = await it.open(server.page(COINRUN_1000_PATH));
  await playKeys(page, COINRUN_1000);
  await waitForText(page.locator("#message"), "Level complete");
  await page.click("#replay");
  await waitForStep(page, 0);
  return page;
}

async function waitForStep(page, step) {
  await waitForText(figure(page, "#figures", "Step"), new RegExp(`^${step} of ${COINRUN_1000_STEPS}$`));
}

async function seek(page, step) {
  await page.locator("#row").fill(String(step));
  await waitForStep(page, step);
}

test("the program of a step in Python has the same observation, and that of an episode's end its fingerprint", async () => {
  const page = await openReplay();
  await seek(page, 12);
  const program = await copied(page);
  assert.match(program, /12 of 35 steps/);
  const middle = await runPython(program);
  assert.equal(middle.digest, await observation(page));
  const argument = `server="${server.address}"`;
  assert(program.includes(argument), "the program names this server");
  const remote = await runPython(program.replace("\n)\nwith pool:", `\n    ${argument},\n)\nwith pool:`));
  assert.deepEqual(remote, middle);
  assert.deepEqual(middle.fingerprints, []);
  await seek(page, COINRUN_1000_STEPS);
  const end = await runPython(await copied(page));
  assert.equal(end.digest, await observation(page));
  assert.deepEqual(end.fingerprints, [await figure(page, "#figures", "Fingerprint").textContent()]);
  await seek(page, 0);
  assert.equal((await runPython(await copied(page))).digest, await observation(page));
});

test("the program of a trace of several environments has their number, the levels and the options", async () => {
  const page = await it.open(server.page("/replay"));
  for (const name of ["miner.memory.levels200", "coinrun.hard.mono-fullview", "maze.easy.sequential"]) {
    await page.setInputFiles("#file", join(GOLDEN, `${name}.trace`));
    await waitForText(page.locator("#name"), `${name}.trace`);
    await waitForText(page.locator("#verdict"), "Identical to the recording");
    await page.locator("#row").fill("40");
    await waitForText(figure(page, "#figures", "Step"), /^40 of /);
    assert.equal((await runPython(await copied(page))).digest, await observation(page), name);
  }
});

test("the program of a level in Python has the level's first observation, also with options and in exploration", async () => {
  for (const query of ["game=maze&mode=hard&level=41&use_backgrounds=false&restrict_themes=true", "game=coinrun&mode=exploration"]) {
    const page = await it.open(server.page(`/play?${query}`));
    await waitForText(page.locator("#message"), "Press an arrow key to begin.");
    assert.equal((await runPython(await copied(page))).digest, await observation(page));
  }
});

// Presses a key, which begins the level, and "." before the level runs by itself.
function holdAndStep(page, key) {
  return page.evaluate((code) => {
    for (const pressed of [{ key: code, code }, { key: ".", code: "Period" }]) {
      document.body.dispatchEvent(new KeyboardEvent("keydown", { ...pressed, bubbles: true }));
    }
  }, key);
}

test("a play continues a replay from a step, returns to it, and its trace has all steps", async () => {
  const page = await openReplay();
  await seek(page, 21);
  const shown = await picture(page, "#human");
  await page.click("#play-here");
  await page.waitForURL("**/play?step=21");
  const step = figure(page, "#figures", "Step");
  await waitForText(step, /^21$/);
  await waitForPicture(page, "#human", (one) => one === shown);
  await waitForText(page.locator("#from"), "Continues coinrun.easy.1000.trace from step 21.");
  assert.equal(await figure(page, "#figures", "Level seed").textContent(), "1000");
  assert.equal(await page.inputValue("[name=level]"), "1000");

  // The same keys as in the replay reach the coin.
  const begin = page.locator("#message");
  await waitForText(begin, "Press an arrow key to begin.");
  await holdAndStep(page, "ArrowRight");
  await waitForText(step, /^22$/);
  for (let next = 23; next <= COINRUN_1000_STEPS; next += 1) {
    await page.keyboard.press(".");
    await waitForText(step, new RegExp(`^${next}$`));
  }
  await page.keyboard.up("ArrowRight");
  await waitForText(page.locator("#message"), `Level complete: score 10 in ${COINRUN_1000_STEPS} steps.`);

  await page.keyboard.press("r");
  await waitForText(step, /^21$/);
  await waitForPicture(page, "#human", (one) => one === shown);
  await page.keyboard.press(".");
  await waitForText(step, /^22$/);
  await page.click("#replay");
  await waitForText(figure(page, "#figures", "Step"), "0 of 22");
  assert.equal(await page.locator("#verdict").textContent(), "Identical to the recording");
  await page.locator("#row").fill("21");
  await waitForText(figure(page, "#figures", "Step"), "21 of 22");
  await waitForPicture(page, "#human", (one) => one === shown);
});

test("a continued play leads to other levels, and its link to nothing in another tab", async () => {
  const page = await openReplay();
  await seek(page, 5);
  await page.click("#play-here");
  await waitForText(figure(page, "#figures", "Step"), /^5$/);
  const link = page.url();
  await page.keyboard.press("n");
  await waitForText(figure(page, "#figures", "Level seed"), /^1001$/);
  assert.equal(new URL(page.url()).search, "?game=coinrun&mode=easy&level=1001");
  assert.equal(await page.locator("#from").textContent(), "");

  const other = await it.open(link);
  await waitForText(other.locator("#wrong"), "This link continues a replay that only the tab with its trace has.");
  assert.equal(await other.locator("#stage").isVisible(), false);
});
