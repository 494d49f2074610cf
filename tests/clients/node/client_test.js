// Connections to a real server: catalog, pools by name, errors, unix sockets, tokens, TLS.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, test } from "node:test";
import {
  AlreadyExistsError, CancelledError, connect, InvalidArgumentError, NotFoundError, ResourceExhaustedError,
  ServerProcess, UnauthenticatedError, UnavailableError,
} from "../../../clients/node/dist/index.js";
import { easy, withServer } from "./server.js";

const it = withServer();
const folder = mkdtempSync(join(tmpdir(), "procgen-node-"));
after(() => rmSync(folder, { recursive: true }));

test("the catalog contains games and limits", async () => {
  const { catalog } = it.client;
  assert.equal(catalog.games.length, 16);
  assert.equal(catalog.actions.length, 15);
  assert(catalog.limits.requestBytesMax >= 65536n);
  assert.equal((await it.client.load()).draining, false);
});

test("pools are created, found, listed, renewed and deleted", async () => {
  const pool = await it.client.createPool(easy(["maze"], 2, { leaseDuration: { seconds: 90n } }), { poolId: "mine" });
  assert.equal(pool.name, "pools/mine");
  await assert.rejects(it.client.createPool(easy(["maze"], 2), { poolId: "mine" }), AlreadyExistsError);
  const found = await it.client.getPool("pools/mine");
  assert.equal(found.spec.options.randSeed, 5n);
  await pool.renew(3600.5);
  const names = new Map();
  for await (const message of it.client.listPools()) {
    names.set(message.name, message.spec.leaseDuration);
  }
  assert.equal(names.get("pools/mine").seconds, 3600n);
  assert.equal(names.get("pools/mine").nanos, 500_000_000);
  await assert.rejects(pool.renew(0.5), InvalidArgumentError);
  await assert.rejects(pool.renew(25 * 3600), ResourceExhaustedError);
  await it.client.deletePool("pools/mine");
  await assert.rejects(it.client.deletePool("pools/mine"), NotFoundError);
  await pool.close();
});

test("errors are typed and keep the server's message", async () => {
  await assert.rejects(it.client.createPool({ games: ["pong"], envCount: 1 }), (error) => {
    assert(error instanceof NotFoundError);
    assert.equal(error.code, "NOT_FOUND");
    return /pong/.test(error.message);
  });
  await assert.rejects(it.client.createPool({ games: ["maze"], envCount: 0 }), InvalidArgumentError);
  await assert.rejects(it.client.createPool({ games: ["maze"], envCount: 1.5 }), /PoolSpec|CreatePoolRequest/);
});

test("a connection without server times out", async () => {
  const connecting = connect("127.0.0.1:1", { timeoutMs: 300 });
  await assert.rejects(connecting, (error) => error instanceof UnavailableError && /127\.0\.0\.1:1 .*0\.3 s/.test(error.message));
});

test("a closed client rejects calls", async () => {
  const client = await connect(it.server.address);
  const pool = await client.createPool(easy(["maze"], 1), { poolId: "left" });
  client.close();
  await assert.rejects(client.load(), CancelledError);
  await assert.rejects(pool.step([4]), CancelledError);
  await it.client.deletePool("pools/left");
});

test("unix sockets are supported", async () => {
  const server = await ServerProcess.start({ flags: [`--address=unix:${join(folder, "socket")}`, "--workers=1"] });
  const client = await connect(server.address);
  const pool = await client.createPool(easy(["maze"], 1));
  assert.equal((await pool.observe()).envCount, 1);
  await pool.close();
  client.close();
  assert.equal(await server.stop(), 0);
});

function openssl(...args) {
  execFileSync("openssl", args, { cwd: folder, stdio: "ignore" });
}

function makeCertificates() {
  const key = ["-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes"];
  openssl("req", "-x509", ...key, "-keyout", "ca.key", "-out", "ca.pem", "-subj", "/CN=authority", "-days", "2");
  for (const name of ["server", "client"]) {
    writeFileSync(join(folder, "names"), "subjectAltName=IP:127.0.0.1,DNS:localhost\n");
    openssl("req", ...key, "-keyout", `${name}.key`, "-out", `${name}.csr`, "-subj", `/CN=${name}`);
    openssl("x509", "-req", "-in", `${name}.csr`, "-CA", "ca.pem", "-CAkey", "ca.key", "-CAcreateserial", "-out",
      `${name}.pem`, "-days", "2", "-extfile", "names");
  }
}

test("TLS, client certificates and tokens are sent as the server requires", async () => {
  makeCertificates();
  const path = (name) => join(folder, name);
  writeFileSync(path("tokens"), "alice 0123456789abcdef0123456789abcdef\n", { mode: 0o600 });
  const server = await ServerProcess.start({
    flags: [
      "--workers=1", `--tls_certificate=${path("server.pem")}`, `--tls_key=${path("server.key")}`,
      `--tls_client_ca=${path("ca.pem")}`, `--tokens=${path("tokens")}`,
    ],
  });
  const token = "0123456789abcdef0123456789abcdef";
  const certificates = { ca: path("ca.pem"), certificate: path("client.pem"), key: path("client.key") };
  const client = await connect(server.address, { credentials: { ...certificates, token } });
  const pool = await client.createPool(easy(["maze"], 1), { poolId: "of-alice" });
  assert.equal((await pool.step([4])).envCount, 1);
  for await (const message of client.listPools()) {
    assert.equal(message.owner, "alice");
  }
  await pool.close();
  client.close();
  await assert.rejects(connect(server.address, { credentials: { ...certificates, token: "wrong" } }), UnauthenticatedError);
  const timeoutMs = 500;
  await assert.rejects(connect(server.address, { timeoutMs, credentials: { ca: path("ca.pem"), token } }), UnavailableError);
  await assert.rejects(connect(server.address, { timeoutMs, credentials: { token } }), UnavailableError);
  assert.equal(await server.stop(), 0);
});

test("credentials are not sent over insecure connections", async () => {
  const assertRejects = (credentials, pattern, address = "procgen.example.com:50051") =>
    assert.rejects(connect(address, { credentials }), pattern);
  await assertRejects({ token: "secret" }, /would go to procgen.example.com:50051 in plain text/);
  await assertRejects({ token: "secret" }, /in plain text/, "127.0.0.1.example.com:1");
  await assertRejects({ certificate: "client.pem" }, /give both or none/);
  await assertRejects({ certificate: "client.pem", key: "client.key" }, /give ca/);
  await assertRejects({ ca: "/nowhere/ca.pem" }, NotFoundError);
});
