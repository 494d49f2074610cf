// A server with authentication.

import assert from "node:assert/strict";
import { writeFile } from "node:fs/promises";
import { join } from "node:path";
import { test } from "node:test";
import { enterToken, figure, waitForText, withBrowser } from "../browser.js";
import { Learner, Server, withFolder } from "../server.js";

const TOKEN = "alices-token-0123456789";
const it = withBrowser();
const folder = withFolder();

test("the page asks for a valid token, keeps it for the tab, and never puts it into a URL", async () => {
  await writeFile(join(folder, "tokens"), `alice ${TOKEN}\nbob bobs-token-0123456789\n`, { mode: 0o600 });
  const server = await Server.start(`--tokens=${join(folder, "tokens")}`);
  await Learner.start(server, "hers", ["coinrun"], 4, { PROCGEN_SERVER_TOKEN: TOKEN });
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
  await waitForText(other.locator("#token-hint"), "PROCGEN_SERVER_TOKEN");
  await waitForText(other.locator("#empty-title"), "No pools of your token yet");
  await waitForText(figure(other, "#server", "Pools"), /^1$/);
  assert.equal(await server.stop(), 0);
});

test("a withdrawn token is asked for again, on every page", async () => {
  const file = join(folder, "tokens");
  const tokens = { bob: "bob bobs-token-0123456789\n", both: `alice ${TOKEN}\nbob bobs-token-0123456789\n` };
  await writeFile(file, tokens.both, { mode: 0o600 });
  const server = await Server.start(`--tokens=${file}`);
  const live = await it.open(server.page());
  await enterToken(live, TOKEN);
  await live.locator("#empty").waitFor();
  const play = await it.open(server.page("/play?game=maze&mode=easy&level=5"));
  await enterToken(play, TOKEN);
  await waitForText(play.locator("#message"), "Press an arrow key to begin.");

  await writeFile(file, tokens.bob);
  await waitForText(live.locator("#token-problem"), "The server no longer accepts this token.");
  await play.keyboard.press("n");  // The next level is another pool; the running one would continue.
  await waitForText(play.locator("#token-problem"), "The server no longer accepts this token.");
  assert.equal(await play.locator("#notices").textContent(), "");

  await writeFile(file, tokens.both);
  for (const [page, state] of [[live, "#empty"], [play, "#stage"]]) {
    await enterToken(page, "bobs-token-0123456789");
    await waitForText(page.locator(".link"), "Connected");
    await page.locator(state).waitFor();
  }
  await waitForText(figure(play, "#figures", "Level seed"), /^6$/);
  assert.equal(await server.stop(), 0);
});
