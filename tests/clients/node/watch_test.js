// Watching pools, and reading their episodes, on a real server.

import assert from "node:assert/strict";
import { test } from "node:test";
import {
  AbortedError, CancelledError, connect, EpisodeOutcome, EpisodeSelector, FailedPreconditionError, InvalidArgumentError,
  NotFoundError, ResourceExhaustedError, ServerProcess,
} from "../../../clients/node/dist/index.js";
import { easy, withServer } from "./server.js";

const it = withServer();

test("a pool is watched while it is stepped", async () => {
  const pool = await it.client.createPool(easy(["maze"], 4));
  const moments = pool.watch([3, 0], { sizePx: 64, framesPerSecondMax: 60 });
  const { value: first } = await moments.next();
  assert.deepEqual(first.frames.map((frame) => [frame.environment, frame.sizePx]), [[3, 64], [0, 64]]);
  assert.equal(first.sequenceNumber, 0n);
  const { observations } = await pool.step([7, 4, 5, 1]);
  const { value: second } = await moments.next();
  assert.equal(second.sequenceNumber, 1n);
  const observed = [3, 0].map((environment) => observations.subarray(environment * 12288, (environment + 1) * 12288));
  assert.deepEqual(second.frames.map((frame) => Buffer.compare(frame.image, observed.shift())), [0, 0]);
  await moments.return();
  await pool.close();
});

test("the default is the human view of the first 16 environments", async () => {
  const pool = await it.client.createPool(easy(["maze"], 17));
  for await (const { frames } of pool.watch()) {
    assert.deepEqual(frames.map((frame) => frame.environment), [...Array(16).keys()]);
    assert(frames.every((frame) => frame.image.length === 256 * 256 * 3));
    break;
  }
  await pool.close();
});

test("a slow watcher skips frame sets", async () => {
  const pool = await it.client.createPool(easy(["bigfish"], 1));
  const [slow, quick] = [0, 0].map(() => pool.watch([0], { sizePx: 64, framesPerSecondMax: 60 }));
  await slow.next();
  for await (const { sequenceNumber } of quick) {
    if (sequenceNumber >= 20n) {
      break;
    }
    await pool.step([4]);
  }
  let seen = 0;
  for await (const { sequenceNumber } of slow) {
    seen += 1;
    if (sequenceNumber >= 20n) {
      break;
    }
  }
  assert(seen < 10, `${seen} moments of 20 waited to be read`);
  await pool.close();
});

test("frame sizes are limited by the server", async () => {
  const server = await ServerProcess.start({ flags: ["--workers=1", "--response_bytes_max=1048576"] });
  const client = await connect(server.address);
  const pool = await client.createPool(easy(["maze"], 7));
  assert.equal((await pool.render()).length, 7);
  for await (const { frames } of pool.watch([0, 1, 2, 3])) {
    assert.equal(frames.length, 4);
    break;
  }
  await assert.rejects(pool.watch().next(), (error) => {
    assert(error instanceof ResourceExhaustedError);
    return /has room for 5 frames of 256 x 256 pixels/.test(error.message);
  });
  await pool.close();
  client.close();
  assert.equal(await server.stop(), 0);
});

test("frames beyond the default message size are received", async () => {
  const pool = await it.client.createPool(easy(["maze"], 16));
  for await (const { frames } of pool.watch(undefined, { sizePx: 512 })) {
    assert.equal(frames.length, 16);
    break;
  }
  await pool.close();
});

test("a watch ends with an error", async () => {
  const pool = await it.client.createPool(easy(["maze"], 1));
  const assertRejects = (moments, pattern) =>
    assert.rejects(moments.next(), (error) => error instanceof InvalidArgumentError && pattern.test(error.message));
  await assertRejects(pool.watch([1]), /environments/);
  await assertRejects(pool.watch([0], { framesPerSecondMax: 61 }), /frames_per_second_max/);
  await assertRejects(pool.watch([0], { sizePx: 8 }), /sizePx is 8, allowed: 16 to 2048/);
  const moments = pool.watch();
  await moments.next();
  await pool.close();
  await assert.rejects(moments.next(), AbortedError);
  await assert.rejects(pool.watch().next(), NotFoundError);
});

test("an AbortSignal ends a watch", async () => {
  const pool = await it.client.createPool(easy(["maze"], 1));
  const controller = new AbortController();
  const moments = pool.watch([0], { signal: controller.signal });
  await moments.next();
  const next = moments.next();
  controller.abort(new Error("enough"));
  await assert.rejects(next, (error) => error instanceof CancelledError && error.cause.message === "enough");
  await pool.close();
});

test("an episode is found and replayed", async () => {
  const pool = await it.client.createPool(easy(["coinrun"], 2));
  await assert.rejects(pool.getEpisode(1), FailedPreconditionError);
  const rewards = [];
  let fingerprint;
  for (const action of [7, 8, 7, -1]) {
    const batch = await pool.step([4, action]);
    rewards.push(batch.rewards[1]);
    [fingerprint] = batch.fingerprints;
  }
  const episode = await pool.getEpisode(1);
  assert.deepEqual([...episode.actions], [7, 8, 7, 255]);
  assert.deepEqual(episode.rewards, rewards);
  assert.equal(episode.outcome, EpisodeOutcome.TERMINATED);
  assert.equal(BigInt.asUintN(64, episode.fingerprint), fingerprint);
  assert.deepEqual([...(await pool.getEpisode(0, EpisodeSelector.CURRENT)).actions], [4, 4, 4, 4]);
  await assert.rejects(pool.getEpisode(2), InvalidArgumentError);
  await pool.step([4, -1]);
  const found = await pool.findEpisode(1, fingerprint);
  assert.deepEqual([...found.actions], [...episode.actions]);
  assert.equal(found.fingerprint, episode.fingerprint);
  await assert.rejects(pool.findEpisode(0, fingerprint), NotFoundError);
  await pool.close();

  const again = await it.client.createPool({ games: [episode.game], envCount: 1, options: episode.options });
  let last;
  for (const action of [7, 8, 7, -1]) {
    last = await again.step([action]);
    assert.equal(last.rewards[0], rewards.shift());
  }
  assert.equal(last.fingerprints[0], fingerprint);
  await again.close();
});
