// A server with authentication.

import assert from "node:assert/strict";
import { mkdtemp, rm, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";
import { enterToken, waitForText, withBrowser } from "./browser.js";
import { Learner, Server } from "./server.js";

const TOKEN = "alices-token-0123456789";
const it = withBrowser();

test("the page asks for a valid token, keeps it for the tab, and never puts it into a URL", async () => {
  const folder = await mkdtemp(join(tmpdir(), "procgen-web-"));
  await writeFile(join(folder, "tokens"), `alice ${TOKEN}\nbob bobs-token-0123456789\n`, { mode: 0o600 });
  const server = await Server.start(`--tokens=${join(folder, "tokens")}`);
  const learner = await Learner.start(server, "hers", ["coinrun"], 4, { credentials: { token: TOKEN } });
  const page = await it.open(server.page());
  const addresses = [];
  // The dialog cannot be dismissed: without a token a page shows nothing.
  for (let i = 0; i < 3; i += 1) {
    await page.keyboard.press("Escape");
  }
  page.on("request", (request) => addresses.push(request.url()));
  await enterToken(page, "wrong-token-0123456789");
  await waitForText(page.locator("#token-problem"), "The server does not know this token.");
  await enterToken(page, TOKEN);
  await waitForText(page.locator("#pool-name"), "pools/hers");
  await waitForText(page.locator("#pool-about"), "owner alice");
  await page.reload();
  await waitForText(page.locator("#pool-name"), "pools/hers");
  assert(addresses.length > 0);
  assert(addresses.every((address) => !address.includes("token-")));

  const other = await it.open(server.page());
  await enterToken(other, "bobs-token-0123456789");
  await other.locator("#empty").waitFor();
  await learner.stop();
  assert.equal(await server.stop(), 0);
  await rm(folder, { recursive: true });
});
