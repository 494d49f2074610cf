// Streams that outlive their connections.

import assert from "node:assert/strict";
import { createHash } from "node:crypto";
import { once } from "node:events";
import { mkdtemp, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";
import { connect, Encoding, NotFoundError, ServerProcess, UnavailableError } from "../../../clients/node/dist/index.js";
import { actionsOf, FaultProxy, easy, withServer } from "./server.js";

const it = withServer();
const envCount = 12;
const half = envCount / 2;

function digest(batch) {
  const hash = createHash("sha256");
  for (const [name, value] of Object.entries(batch).sort()) {
    hash.update(name).update(ArrayBuffer.isView(value) ? value : JSON.stringify(value));
  }
  return hash.digest("hex");
}

// The client does not retry connect and attach.
async function persistently(attempt) {
  for (;;) {
    try {
      return await attempt();
    } catch (error) {
      if (!(error instanceof Error && "code" in error)) {
        throw error;
      }
    }
  }
}

// Steps the two halves of the pool in turn, with pipelined requests.
async function traceOf(pool, stepCount) {
  await persistently(() => pool.attach({ takeOver: true, responseBytesMax: 65536 }));
  const sent = [];
  const trace = [];
  for (let step = 0; step < stepCount; step += 1) {
    sent.push(pool.step(actionsOf(step, half), { firstEnv: (step % 2) * half, envCount: half }));
    if (sent.length === pool.requestsInFlightMax) {
      trace.push(digest(await sent.shift()));
    }
  }
  return [...trace, ...(await Promise.all(sent)).map(digest)];
}

for (const [name, encoding, stepCount, bytesBetweenFaults, leastBreakCount] of [
  ["raw", Encoding.RAW, 100, 120_000, 15],
  ["zstd", Encoding.DELTA_ZSTD, 150, 20_000, 5],
]) {
  test(`a faulty network loses nothing: ${name}`, { skip: !process.env.PROCGEN_FAULT_PROXY }, async (t) => {
    const referencePool = await it.client.createPool(easy(["maze", "bigfish"], envCount));
    const expected = await traceOf(referencePool, stepCount);
    await referencePool.close();
    const network = await FaultProxy.start(t, it.server.address, 11, bytesBetweenFaults);
    const { name } = await it.client.createPool(easy(["maze", "bigfish"], envCount, { encoding }));
    const learner = await persistently(() => connect(network.address));
    t.after(() => learner.close());
    const pool = await persistently(() => learner.getPool(name, { requestsInFlightMax: 3 }));
    assert.deepEqual(await traceOf(pool, stepCount), expected);
    learner.close();
    assert((await network.stop()) >= leastBreakCount);
    await it.client.deletePool(name);
  });
}

async function untilLost(pool) {
  for (;;) {
    await pool.step([4, 4]);
  }
}

test("reconnecting to a lost server times out", async () => {
  const server = await ServerProcess.start({ flags: ["--workers=1"] });
  const client = await connect(server.address, { reconnectTimeoutMs: 500 });
  const pool = await client.createPool(easy(["maze"], 2));
  await pool.step([4, 4]);
  server.process.kill("SIGKILL");
  const begin = performance.now();
  await assert.rejects(untilLost(pool), (error) =>
    error instanceof UnavailableError && /made again within 0\.5 s/.test(error.message));
  assert(performance.now() - begin < 10_000);
  client.close();
});

test("without a reconnect timeout the first loss is an error", async () => {
  const server = await ServerProcess.start({ flags: ["--workers=1"] });
  const client = await connect(server.address, { reconnectTimeoutMs: 0 });
  const pool = await client.createPool(easy(["maze"], 2));
  await pool.step([4, 4]);
  server.process.kill("SIGKILL");
  await assert.rejects(untilLost(pool), (error) =>
    error instanceof UnavailableError && !/made again/.test(error.message));
  client.close();
});

test("a draining server is not contacted again", async () => {
  const server = await ServerProcess.start({ flags: ["--workers=1", "--drain_timeout=1s"] });
  const client = await connect(server.address, { reconnectTimeoutMs: 600_000 });
  const pool = await client.createPool(easy(["maze"], 2));
  await pool.step([4, 4]);
  const stopped = server.stop();
  await assert.rejects(untilLost(pool), (error) => error instanceof UnavailableError && /drains/.test(error.message));
  await pool.close();
  client.close();
  await stopped;
});

test("a lost pool's namesake on a restarted server is not deleted", async (t) => {
  const folder = await mkdtemp(join(tmpdir(), "procgen-node-"));
  t.after(() => rm(folder, { recursive: true }));
  const flags = [`--address=unix:${folder}/socket`, "--workers=1"];
  const lost = await ServerProcess.start({ flags });
  const client = await connect(lost.address);
  const pool = await client.createPool(easy(["maze"], 2));
  await pool.step([4, 4]);
  lost.process.kill("SIGKILL");
  await once(lost.process, "exit");
  await rm(`${folder}/socket`, { force: true });
  const server = await ServerProcess.start({ flags });
  t.after(() => server.stop());
  await assert.rejects(untilLost(pool), NotFoundError);
  const other = await connect(server.address);
  t.after(() => other.close());
  const namesake = await other.createPool(easy(["maze"], 2));
  assert.equal(namesake.name, pool.name);
  await pool.close();
  assert.equal((await other.getPool(pool.name)).name, pool.name);
  client.close();
});
