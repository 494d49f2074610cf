// Nodes of a cluster.

import assert from "node:assert/strict";
import { test } from "node:test";
import {
  CancelledError, connect, NodeRole, ServerProcess, UnavailableError,
} from "../../../clients/node/dist/index.js";
import { easy, withServer } from "./server.js";

const it = withServer();

test("a server without a cluster lists itself", async () => {
  const { nodes, cluster, localNode } = await it.client.listNodes();
  assert.equal(cluster, "");
  assert.deepEqual(nodes.map((node) => node.name), [localNode]);
  assert.equal(nodes[0].address, it.client.address);
  assert.equal(nodes[0].role, NodeRole.HOST);
  assert.equal(nodes[0].healthy, true);
});

test("watchers receive each change", async () => {
  let pool;
  for await (const { nodes } of it.client.watchNodes()) {
    if (pool === undefined) {
      assert.equal(nodes[0].envCount, 0);
      pool = await it.client.createPool(easy(["maze"], 3));
    } else if (nodes[0].envCount === 3) {
      break;
    }
  }
  await pool.close();
});

test("an AbortSignal ends a watcher", async () => {
  const controller = new AbortController();
  const watching = it.client.watchNodes({ signal: controller.signal });
  await watching.next();
  controller.abort(new Error("enough"));
  await assert.rejects(watching.next(), (error) => error instanceof CancelledError && error.cause.message === "enough");
  await assert.rejects(it.client.watchNodes({ signal: controller.signal }).next(), CancelledError);
});

test("watchers are notified when the server stops", async () => {
  const server = await ServerProcess.start({ flags: ["--workers=1"] });
  const client = await connect(server.address);
  const watching = client.watchNodes();
  await watching.next();
  const stopped = server.stop();
  await assert.rejects(async () => {
    for (;;) {
      await watching.next();
    }
  }, UnavailableError);
  client.close();
  await assert.rejects(client.watchNodes().next(), CancelledError);
  assert.equal(await stopped, 0);
});
