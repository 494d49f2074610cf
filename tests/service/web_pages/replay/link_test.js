// The replay page: speed, keys, and links to a step of a pool's episode.

import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";
import { decodeMessages } from "../bridge_messages.js";
import { figure, picture, waitForPicture, waitForText, withBrowser } from "../browser.js";
import { Pool, withServer } from "../server.js";

const STEPS = 60;
const RIGHT = 7;
const END = -1;

const it = withBrowser();
const server = withServer();
let pool;

// A pool whose environment 1 has ended an episode of 60 steps.
beforeEach(async () => {
  pool = await Pool.open(server, ["maze"], 2);
  for (let step = 1; step < STEPS; step += 1) {
    await pool.step([4, step % 2 ? RIGHT : 1]);
  }
  await pool.step([4, END]);
});

function waitForStep(page, step) {
  return waitForText(figure(page, "#figures", "Step"), new RegExp(`^${step} of ${STEPS}$`));
}

async function openEpisode(query = "environment=1") {
  const page = await it.open(server.page(`/replay?pool=${encodeURIComponent(pool.name)}&${query}`));
  await waitForText(page.locator("#verdict"), "Identical to the recording");
  return page;
}

function waitForLink(page, step) {
  return page.waitForURL(new RegExp(`&episode=[0-9a-f]{16}&step=${step}$`));
}

test("keys step, jump and run the replay wherever the focus is, except in fields and on buttons", async () => {
  const page = await openEpisode();
  await waitForStep(page, 0);
  await page.keyboard.press("ArrowRight");
  await waitForStep(page, 1);
  await page.keyboard.press("End");
  await waitForStep(page, STEPS);
  await page.keyboard.press("ArrowLeft");
  await waitForStep(page, STEPS - 1);
  await page.keyboard.press("Home");
  await waitForStep(page, 0);
  await page.keyboard.press("Space");
  await waitForText(page.locator("#run"), "Pause");
  await page.keyboard.press("Space");
  await waitForText(page.locator("#run"), "Play");

  await page.locator("#row").focus();
  await page.keyboard.press("End");
  await waitForStep(page, STEPS);
  await page.keyboard.press("ArrowLeft");
  await waitForStep(page, STEPS - 1);
  await page.locator("#speed").focus();
  await page.keyboard.press("ArrowRight");
  assert.equal(await page.inputValue("#speed"), "2");
  await page.locator("#first").focus();
  await page.keyboard.press("Space");
  await waitForStep(page, 0);
  assert.match(await page.locator("#run").textContent(), /^Play/);
});

test("a replay runs at the chosen speed", async () => {
  const page = await it.open("about:blank");
  let steps = [];  // between images
  await decodeMessages(page, server, {
    onSent: ({ message: { request } }) => {
      if (request?.case === "step") {
        steps[steps.length - 1] += 1;
      } else if (request?.case === "render") {
        steps.push(0);
      }
    },
  });
  await page.goto(server.page(`/replay?pool=${encodeURIComponent(pool.name)}&environment=1`));
  await waitForStep(page, 0);
  await page.selectOption("#speed", "0.25");
  const begin = performance.now();
  await page.click("#run");
  const shown = await page.waitForFunction(() => {
    const text = [...document.querySelectorAll("#figures div")].map((one) => one.textContent).join(" ");
    const step = Number(/Step\s*(\d+) of/.exec(text)?.[1]);
    return step >= 3 && step;
  });
  const step = await shown.jsonValue();
  const stepMs = (performance.now() - begin) / step;
  assert(stepMs > 500 / 3, `${step} steps at 0.25x took ${stepMs} ms each, they should take 267`);

  await page.click("#first");
  await waitForStep(page, 0);
  await page.selectOption("#speed", "16");
  steps = [0];
  await page.click("#run");
  await waitForStep(page, STEPS);
  await waitForText(page.locator("#run"), "Play");
  // Of 240 steps a second, each eighth is shown. The last ends the episode, and a further one begins the next.
  assert.deepEqual(steps, [8, 8, 8, 8, 8, 8, 8, 4, 1, 0]);
});

test("the URL of an episode's step opens the same frame in another browser", async () => {
  const page = await openEpisode();
  await page.locator("#row").fill("21");
  await waitForStep(page, 21);
  await waitForLink(page, 21);
  const query = new URL(page.url()).searchParams;
  assert.equal(query.get("pool"), pool.name);
  assert.equal(query.get("environment"), "1");
  const shown = await picture(page, "#human");

  const other = await it.open(page.url());
  await waitForStep(other, 21);
  await waitForPicture(other, "#human", (one) => one === shown);
});

test("a link stays valid when its environment ends another episode", async () => {
  const page = await openEpisode("environment=1&step=5");
  await waitForStep(page, 5);
  await waitForLink(page, 5);
  await pool.step([4, RIGHT]);
  await pool.step([4, END]);
  const other = await it.open(page.url());
  await waitForStep(other, 5);
});

test("an episode that the server has no more is reported as gone, except in the tab that has it", async () => {
  const page = await openEpisode("environment=1&step=5");
  await waitForStep(page, 5);
  await waitForLink(page, 5);
  const link = page.url();
  // The list of the last 1,000 episodes has 500 of each environment.
  for (let ended = 0; ended < 1000; ended += 1) {
    await pool.step([END, END]);
  }
  await pool.step([4, RIGHT]);
  await pool.step([4, END]);

  const other = await it.open(link);
  await waitForText(other.locator("#wrong"), /The episode of this link is gone\. .* has no recording of episode [0-9a-f]{16}/i);
  assert.equal(await other.locator("#replay").isVisible(), false);
  await page.reload();
  await waitForStep(page, 5);

  await other.click("#wrong a:has-text('Last episode of environment 1')");
  await waitForText(figure(other, "#figures", "Step"), "0 of 2");
  assert.equal(await other.locator("#wrong").isVisible(), false);
});

test("a link to no pool, no episode or no step is reported", async () => {
  const name = encodeURIComponent(pool.name);
  for (const [query, text] of [
    ["pool=pools%2Fnone&environment=0&step=3", "The episode of this link is gone. "],
    [`pool=${name}&environment=0`, "The episode of this link is gone. Environment 0 has ended no episode yet"],
    [`pool=${name}&environment=7`, "The episode of this link is gone. "],
    [`pool=${name}&environment=x`, "The environment of this link is “x”, allowed: integers from 0."],
    [`pool=${name}&environment=1&step=-1`, "The step of this link is “-1”, allowed: integers from 0."],
  ]) {
    const page = await it.open(server.page(`/replay?${query}`));
    await waitForText(page.locator("#wrong"), text);
    assert.equal(await page.locator("#replay").isVisible(), false);
  }
  const page = await openEpisode("environment=1&step=999");
  await waitForText(page.locator("#notices"), `This link is to step 999, the replay has ${STEPS} steps.`);
  await waitForStep(page, STEPS);
});
