// Pages over TLS, with authentication.

import assert from "node:assert/strict";
import { execFile } from "node:child_process";
import { writeFile } from "node:fs/promises";
import { join } from "node:path";
import { test } from "node:test";
import { promisify } from "node:util";
import { enterToken, figure, waitForChange, waitForText, withBrowser } from "../browser.js";
import { Learner, Server, withFolder } from "../server.js";

const TOKEN = "alices-token-0123456789";
const it = withBrowser();
const folder = withFolder();

// Makes a self-signed certificate for loopback. Returns the paths of certificate and key.
async function makeCertificate() {
  const [certificate, key] = [join(folder, "certificate.pem"), join(folder, "key.pem")];
  await promisify(execFile)("openssl", [
    "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-days", "2", "-subj", "/CN=server",
    "-addext", "subjectAltName=IP:127.0.0.1", "-keyout", key, "-out", certificate,
  ]);
  return [certificate, key];
}

test("over https the page asks for the token, watches pools and plays levels, by wss only", async () => {
  const [certificate, key] = await makeCertificate();
  await writeFile(join(folder, "tokens"), `alice ${TOKEN}\n`, { mode: 0o600 });
  const server = await Server.start(
    `--tls_certificate=${certificate}`, `--tls_key=${key}`, `--tokens=${join(folder, "tokens")}`);
  await Learner.start(server, "hers", ["coinrun"], 4, { PROCGEN_SERVER_CA: certificate, PROCGEN_SERVER_TOKEN: TOKEN });
  assert.match(server.page(), /^https:/);

  // The browser trusts self-signed certificates only in contexts that allow it.
  await assert.rejects(it.open(server.page()), /ERR_CERT_AUTHORITY_INVALID/);
  const page = await it.open("about:blank", { ignoreHTTPSErrors: true });
  const addresses = [];
  page.on("request", (request) => addresses.push(request.url()));
  page.on("websocket", (socket) => addresses.push(socket.url()));
  await page.goto(server.page());
  assert.equal(await page.evaluate(() => isSecureContext), true);
  await enterToken(page, "wrong-token-0123456789");
  await waitForText(page.locator("#token-problem"), "The server does not know this token.");
  await enterToken(page, TOKEN);
  await waitForText(page.locator("#pool-name"), "pools/hers");
  await waitForChange(page, "#mosaic li:first-child canvas");

  await page.click("text=Play");
  await waitForText(page.locator("#message"), "Press an arrow key to begin.");
  await page.keyboard.press(".");
  await waitForText(figure(page, "#figures", "Step"), /^1$/);

  const { host } = new URL(server.page());
  assert(addresses.includes(`wss://${host}/bridge`));
  const others = addresses.filter((address) => !/^(https|wss):/.test(address) || new URL(address).host !== host);
  assert.deepEqual(others, []);
  assert(addresses.every((address) => !address.includes("token-")));
  assert.equal(await server.stop(), 0);
});
