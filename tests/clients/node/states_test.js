// Snapshots, clones and rendered frames, on a real server.

import assert from "node:assert/strict";
import { test } from "node:test";
import {
  DataLossError, FailedPreconditionError, InvalidArgumentError, NotFoundError,
} from "../../../clients/node/dist/index.js";
import { actionsOf, easy, withServer } from "./server.js";

// A request limit that not all snapshots fit into.
const it = withServer("--request_bytes_max=65536");

test("restored states continue as the originals", async () => {
  const pool = await it.client.createPool(easy(["bigfish", "maze"], 80));
  for (let step = 0; step < 5; step += 1) {
    await pool.step(actionsOf(step, 80));
  }
  const states = await pool.saveStates();
  assert.equal(states.length, 80);
  assert(states.reduce((sum, state) => sum + state.length, 0) > 65536);
  const before = await pool.step(actionsOf(9, 80));
  await pool.restoreStates(states);
  const after = await pool.step(actionsOf(9, 80));
  assert.deepEqual(after.observations, before.observations);
  assert.deepEqual(after.rewards, before.rewards);

  await pool.restoreStates(new Map([[3, states[1]]]));
  const two = await pool.saveStates([3, 1]);
  assert.deepEqual(two[0], states[1]);
  assert.notDeepEqual(two[1], states[1]);
  await pool.close();
});

test("environments are cloned within a pool and from another", async () => {
  const pool = await it.client.createPool(easy(["maze"], 3));
  const other = await it.client.createPool(easy(["maze"], 1, { options: { randSeed: 9n } }));
  await pool.cloneStates([[0, 1], [0, 2]]);
  const { levelSeeds } = await pool.observe();
  assert.deepEqual([...levelSeeds], Array(3).fill(levelSeeds[0]));
  await other.cloneStates([[2, 0]], { sourcePool: pool });
  assert.equal((await other.observe()).levelSeeds[0], levelSeeds[0]);
  await assert.rejects(other.cloneStates([[0, 0]], { sourcePool: "pools/none" }), NotFoundError);
  await pool.close();
  await other.close();
});

test("a damaged or missing snapshot is rejected", async () => {
  const pool = await it.client.createPool(easy(["maze"], 2));
  const [state] = await pool.saveStates([0]);
  const damaged = Uint8Array.from(state);
  damaged[damaged.length - 1] ^= 1;
  await assert.rejects(pool.restoreStates(new Map([[0, damaged]])), DataLossError);
  await assert.rejects(pool.restoreStates([state]), /states has 1 entries; there are 2 environments/);
  const sent = pool.observe();
  await assert.rejects(pool.saveStates(), FailedPreconditionError);
  await sent;
  await pool.close();
});

test("environments are rendered at any size, also beyond one message", async () => {
  const pool = await it.client.createPool(easy(["coinrun"], 7));
  const frames = await pool.render(undefined, 512);
  assert.deepEqual(frames.map((frame) => frame.environment), [0, 1, 2, 3, 4, 5, 6]);
  assert(frames.every((frame) => frame.image.length === 512 * 512 * 3));
  assert.equal((await pool.render([6], 2048))[0].sizePx, 2048);
  await assert.rejects(pool.render([0], 8), /sizePx is 8, allowed: 16 to 2048/);
  await assert.rejects(pool.render([7], 64), InvalidArgumentError);
  await pool.close();
});
