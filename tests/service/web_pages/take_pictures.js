// Takes the pictures of the live view in the root's README: `node take_pictures.js URL FOLDER` writes live-view.png, and frames of an
// enlarged environment as frame-00.png and so on. A learner must be training on the server whose pages are at URL.

import { join } from "node:path";
import { chromium } from "playwright-core";

const FRAME_COUNT = 24;
const FRAMES_PER_SECOND = 4;

const [url, folder] = process.argv.slice(2);
if (!folder) {
  console.error("Usage: node take_pictures.js URL FOLDER");
  process.exit(2);
}
const browser = await chromium.launch({ executablePath: process.env.PROCGEN_CHROMIUM ?? "/usr/bin/chromium-headless-shell" });
const page = await browser.newPage({ viewport: { width: 1440, height: 1200 } });
await page.goto(url);
await page.locator("#mosaic li:nth-child(16) canvas").waitFor();
await page.waitForTimeout(5_000);  // plots and pictures are complete
await page.screenshot({ path: join(folder, "live-view.png") });

await page.locator("#mosaic li:first-child canvas").click();
const dialog = page.locator("dialog[open]");
await dialog.locator("canvas").first().waitFor();
await page.waitForTimeout(2_000);
for (let i = 0; i < FRAME_COUNT; ++i) {
  const next = page.waitForTimeout(1_000 / FRAMES_PER_SECOND);
  await dialog.screenshot({ path: join(folder, `frame-${String(i).padStart(2, "0")}.png`) });
  await next;
}
await browser.close();
