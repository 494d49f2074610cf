// A headless Firefox for the tests of a file.

import { once } from "node:events";
import { mkdtempSync, readdirSync, statSync, watch } from "node:fs";
import { rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after } from "node:test";
import { firefox } from "playwright-core";
import { withBrowser } from "./browser.js";

// `firefox.launch` alone expects Playwright's own build of Firefox. With this channel Playwright drives any Firefox, over
// WebDriver BiDi.
const CHANNEL = "moz-firefox";

// Like withBrowser. An error in the console of a page also fails the file. `it.save(page, button, name)` presses a button
// that saves a file whose name matches the expression `name`; it returns the path.
export function withFirefox() {
  const downloadsPath = mkdtempSync(join(tmpdir(), "procgen-web-"));
  const it = withBrowser(() =>
    firefox.launch({ channel: CHANNEL, executablePath: process.env.PROCGEN_FIREFOX, downloadsPath }));
  after(() => rm(downloadsPath, { recursive: true }));
  const { openIn } = it;
  it.openIn = (context, address) => {
    context.on("console", (message) => {
      if (message.type() === "error") {
        it.errors.push(`${address}: ${message.text()}`);
      }
    });
    return openIn(context, address);
  };
  it.save = (page, button, name) => save(downloadsPath, page, button, name);
  return it;
}

// Over WebDriver BiDi, Playwright does not report downloads of a blob, so the folder is watched. Firefox writes into a file
// with another suffix and renames it; until then the file with the name is empty.
async function save(folder, page, button, name) {
  const watcher = watch(folder);
  const signal = AbortSignal.timeout(60_000);
  const find = () => readdirSync(folder).find((file) => name.test(file) && statSync(join(folder, file)).size > 0);
  try {
    await page.click(button);
    while (!find()) {
      await once(watcher, "change", { signal });
    }
    return join(folder, find());
  } finally {
    watcher.close();
  }
}
