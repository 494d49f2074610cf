// Values that the learner sent, along the time line of a replay.

import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { figure, waitForText, withBrowser } from "../browser.js";
import { Pool, withServer } from "../server.js";

const STEPS = 12;
const PROBABILITIES = Array.from({ length: 15 }, (_, action) => (action === 7 ? 0.3 : 0.05));

const it = withBrowser();
const server = withServer();
let pool;
before(async () => {
  pool = await Pool.open(server, ["coinrun"], 1, { pool_id: "annotated" });
  for (let step = 1; step <= STEPS; step += 1) {
    await pool.step([step < STEPS ? 7 : -1], { annotations: { value: [step / 100], action_probabilities: [PROBABILITIES] } });
  }
});
after(async () => {
  await pool.close();
});

const line = (page, name = "value") => page.locator("#annotation-lines .annotation", { hasText: name });
const step = (page) => figure(page, "#figures", "Step");

test("a value is a line over all steps, several values are bars of the shown step", async () => {
  const page = await it.open(server.page("/replay?pool=pools/annotated&environment=0"));
  await waitForText(step(page), `0 of ${STEPS}`);
  assert.match(await line(page).locator("h3").textContent(), /^value – 0\.01 to 0\.12$/);
  assert.equal((await line(page).locator("path").first().getAttribute("d")).split("L").length, STEPS);
  await page.locator("#row").fill("5");
  await waitForText(step(page), `5 of ${STEPS}`);
  await waitForText(line(page).locator(".number").first(), /^0\.05$/);
  assert.match(await line(page, "score").locator("h3").textContent(), /^score 0 0 to 0$/);
  const bars = page.locator("#annotation-bars li");
  assert.equal(await bars.count(), 15);
  assert.equal(await bars.nth(7).textContent(), "RIGHT0.3");
});

test("a saliency map is drawn over the agent's view, in blocks of 4 x 4 pixels", async () => {
  const salient = await Pool.open(server, ["coinrun"], 1, { pool_id: "salient" });
  const map = Array(64 * 64).fill(0);
  map[10 * 64 + 20] = 1;
  await salient.step([7], { annotations: { saliency: [map] } });
  await salient.step([-1]);
  const page = await it.open(server.page("/replay?pool=pools/salient&environment=0&step=1"));
  await waitForText(step(page), "1 of 2");
  const drawn = await page.locator("#saliency").evaluate((canvas) => {
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    return [canvas.width, [...data].flatMap((value, i) => (i % 4 === 3 && value > 0 ? [(i - 3) / 4] : []))];
  });
  assert.deepEqual(drawn, [16, [2 * 16 + 5]]);
  assert.equal(await page.locator("#annotation-bars").isVisible(), false);
  await salient.close();
});

test("a press on the line goes to its step", async () => {
  const page = await it.open(server.page("/replay?pool=pools/annotated&environment=0"));
  await waitForText(step(page), `0 of ${STEPS}`);
  const box = await line(page).locator("svg").boundingBox();
  await line(page).locator("svg").click({ position: { x: box.width * 0.75, y: box.height / 2 } });
  await waitForText(step(page), `${STEPS * 0.75} of ${STEPS}`);
  await waitForText(line(page).locator(".number").first(), /^0\.09$/);
});
