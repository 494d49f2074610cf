// Pools on a real server: batches, slices, pipelined requests, errors, aborted waits.

import assert from "node:assert/strict";
import { test } from "node:test";
import {
  AbortedError, AutoresetMode, CancelledError, Color, connect, FailedPreconditionError, InvalidArgumentError, Layout,
  NotFoundError, observationOf, Transport, UnimplementedError,
} from "../../../clients/node/dist/index.js";
import { actionsOf, easy, withServer } from "./server.js";

const it = withServer();

async function withPool(spec, use, options) {
  const pool = await it.client.createPool(spec, options);
  try {
    return await use(pool);
  } finally {
    await pool.close();
  }
}

test("a new pool has first observations", () =>
  withPool(easy(["maze"], 3), async (pool) => {
    const batch = await pool.observe();
    assert.deepEqual(batch.observationShape, [64, 64, 3]);
    assert.equal(batch.observations.length, 3 * 12288);
    assert.ok(batch.observations.buffer.byteLength > 3 * 12288, "a view of the received message");
    assert.deepEqual([...batch.first], [1, 1, 1]);
    assert.deepEqual([...batch.rewards], [0, 0, 0]);
    assert.equal(batch.sequenceNumber, 1);
    assert.notDeepEqual(observationOf(batch, 0), observationOf(batch, 1));
  }));

test("equal pools give equal batches, with any pipelining and chunking", async () => {
  const whole = await withPool(easy(["maze", "bigfish"], 8), async (pool) => {
    const batches = [];
    for (let step = 0; step < 60; step += 1) {
      batches.push(await pool.step(actionsOf(step, 8)));
    }
    return batches;
  });
  const options = { requestsInFlightMax: 4, chunkCount: 3 };
  await withPool(easy(["maze", "bigfish"], 8), async (pool) => {
    let pending = [];
    for (let step = 0; step < 60; step += 1) {
      const actions = actionsOf(step, 8);
      pending.push(step % 2 ? pool.step(actions) : pool.step(actions.subarray(0, 4), { envCount: 4 }));
      if (step % 2 === 0) {
        pending.push(pool.step(actions.subarray(4), { firstEnv: 4 }));
      } else {
        const [left, right, both] = await Promise.all(pending);
        pending = [];
        assert.deepEqual([...left.levelSeeds, ...right.levelSeeds], [...whole[step - 1].levelSeeds]);
        assert.equal(right.firstEnv, 4);
        assert.equal(Buffer.compare(right.observations, whole[step - 1].observations.subarray(4 * 12288)), 0);
        for (const name of ["observations", "rewards", "fingerprints", "episodeReturns", "terminated"]) {
          assert.deepEqual(both[name], whole[step][name], name);
        }
      }
    }
  }, options);
  assert(whole.some((batch) => batch.fingerprints.length > 0));
});

test("responses of more than 4 MiB are joined", () =>
  withPool(easy(["coinrun"], 400), async (pool) => {
    const batch = await pool.step(new Int32Array(400));
    assert.equal(batch.envCount, 400);
    assert.equal(batch.observations.length, 400 * 12288);
    assert.deepEqual(batch.observations, (await pool.observe()).observations);
  }));

test("formats, ends, resets, levels and samplers follow the protocol", () => {
  const observationFormat = { color: Color.GRAYSCALE, layout: Layout.CHW, sizePx: 32, frameStack: 2 };
  const spec = easy(["maze"], 2, { observationFormat, autoresetMode: AutoresetMode.DISABLED });
  return withPool(spec, async (pool) => {
    assert.deepEqual([...pool.observationShape], [2, 1, 32, 32]);
    const ended = await pool.step([-1, 4], { nextLevels: new Map([[0, 42]]) });
    assert.deepEqual([...ended.terminated], [1, 0]);
    await assert.rejects(pool.step([4, 4]), FailedPreconditionError);
    const begun = await pool.step([4, 4], { resets: [{ environment: 0 }] });
    assert.deepEqual([...begun.first], [1, 0]);
    assert.equal(begun.levelSeeds[0], 42);
    const reset = await pool.reset([{ environment: 1, levelSeed: 7 }], { firstEnv: 1 });
    assert.deepEqual([...reset.levelSeeds], [7]);
    await pool.setLevelSampler({ levelSeeds: [99] });
    assert.deepEqual([...(await pool.reset()).levelSeeds], [99, 99]);
    const blind = await pool.step([4, 4], { observe: false, repeatCount: 5 });
    assert.equal(blind.observations.length, 0);
    assert.deepEqual([...blind.episodeLengths], [5, 5]);
  });
});

test("final observations are returned on request", () =>
  withPool(easy(["maze"], 3), async (pool) => {
    const before = await pool.observe();
    const batch = await pool.step([4, -1, 4], { finalObservations: true });
    assert.equal(batch.fingerprints.length, 1);
    assert.equal(batch.finalObservations.length, 12288);
    assert.notDeepEqual(batch.finalObservations, observationOf(batch, 1));
    assert.deepEqual(Buffer.from(batch.finalObservations), Buffer.from(observationOf(before, 1)));
  }));

test("an invalid argument does not end the stream", () =>
  withPool(easy(["maze"], 2), async (pool) => {
    await assert.rejects(pool.step([4, 99]), { name: "InvalidArgumentError", message: /actions\[1\] is 99, allowed: -1 to 14/ });
    await assert.rejects(pool.step([4, 4, 4]), /actions has 3 entries; .* has 2 environments from 0 on/);
    await assert.rejects(pool.step([4]), /actions has 1 entries; .* has 2 .*firstEnv and envCount choose a slice/);
    await assert.rejects(pool.step([4], { firstEnv: 2 }), /firstEnv is 2, allowed: 0 to 1/);
    await assert.rejects(pool.step([4, 4], { repeatCount: 0 }), /repeatCount is 0, allowed: 1 to 1000/);
    await assert.rejects(pool.step([4, 4], { nextLevels: new Map([[0, 2 ** 40]]) }), InvalidArgumentError);
    assert.equal((await pool.step([4, 4])).sequenceNumber, 1);
  }));

test("an error of the server ends the stream and loses nothing", () =>
  withPool(easy(["maze"], 2), async (pool) => {
    await pool.step([4, 4]);
    await assert.rejects(pool.step([4, 4], { resets: [{ environment: 5 }] }), InvalidArgumentError);
    assert.equal((await pool.step([4, 4])).sequenceNumber, 2);
  }));

test("requests sent ahead are bounded", () =>
  withPool(easy(["maze"], 1), async (pool) => {
    const sent = [pool.step([4]), pool.step([4])];
    await assert.rejects(pool.step([4]), /2 requests to pools\/.* are unanswered, of at most 2/);
    assert.deepEqual((await Promise.all(sent)).map((batch) => batch.sequenceNumber), [1, 2]);
  }));

test("rollout yields the first batch, then the policy's batches", () =>
  withPool(easy(["maze"], 2), async (pool) => {
    const numbers = [];
    for await (const batch of pool.rollout(() => [4, 4], { stepCount: 3 })) {
      numbers.push(batch.sequenceNumber);
    }
    assert.deepEqual(numbers, [1, 2, 3, 4]);
  }));

test("an AbortSignal ends the wait, and the pool continues", () =>
  withPool(easy(["maze"], 2), async (pool) => {
    const abort = new AbortController();
    const reason = new Error("enough");
    const steps = (async () => {
      for await (const batch of pool.rollout(() => [4, 4], { signal: abort.signal })) {
        if (batch.sequenceNumber === 5) {
          abort.abort(reason);
        }
      }
    })();
    await assert.rejects(steps, (error) => error instanceof CancelledError && error.cause === reason);
    assert.equal(pool.inFlight, 0);
    const waiting = new AbortController();
    const sent = pool.step([4, 4], { repeatCount: 1000, signal: waiting.signal });
    waiting.abort();
    await assert.rejects(sent, CancelledError);
    assert.equal((await pool.step([4, 4])).envCount, 2);
    await assert.rejects(it.client.load({ signal: AbortSignal.abort() }), CancelledError);
  }));

test("a pool has one stream at a time, which another can take over", () =>
  withPool(easy(["maze"], 2), async (pool) => {
    await pool.step([4, 4]);
    const other = await it.client.getPool(pool.name);
    await assert.rejects(other.step([4, 4]), FailedPreconditionError);
    await other.attach({ takeOver: true });
    assert.equal((await other.step([4, 4])).sequenceNumber, 2);
    await assert.rejects(pool.step([4, 4]), AbortedError);
    await other.close();
    assert.equal((await pool.step([4, 4])).sequenceNumber, 3);
  }));

test("a closed pool is deleted and sends no more requests", async () => {
  const pool = await it.client.createPool(easy(["maze"], 1));
  await pool.step([4]);
  await pool.close();
  await pool.close();
  await assert.rejects(pool.step([4]), /was closed by this client/);
  await assert.rejects(it.client.getPool(pool.name), NotFoundError);
});

test("shared memory is rejected with a reason", async () => {
  const spec = easy(["maze"], 1, { transport: Transport.SHARED_MEMORY });
  await assert.rejects(it.client.createPool(spec), UnimplementedError);
});

test("pools of several clients run concurrently", async () => {
  const other = await connect(it.server.address);
  await Promise.all([it.client, other].map(async (client) => {
    const pool = await client.createPool(easy(["maze"], 2));
    for (let step = 0; step < 20; step += 1) {
      await pool.step([4, 4]);
    }
    await pool.close();
  }));
  other.close();
});
