// A server for the tests of a file, and connections to it.

import { spawn } from "node:child_process";
import { once } from "node:events";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { createInterface } from "node:readline";
import assert from "node:assert/strict";
import { after, before } from "node:test";
import { connect, DistributionMode, ServerProcess } from "../../../clients/node/dist/index.js";

// A server that stops after the last test and must exit with status 0; `it.client` is connected to it.
export function withServer(...flags) {
  const it = {};
  const folder = mkdtempSync(join(tmpdir(), "procgen-node-"));
  const logPath = join(folder, "log");
  before(async () => {
    it.server = await ServerProcess.start({ flags: ["--workers=2", ...flags], logPath });
    it.client = await connect(it.server.address);
  });
  after(async () => {
    it.client.close();
    const status = await it.server.stop();
    const log = readFileSync(logPath, "utf8");
    rmSync(folder, { recursive: true });
    assert.equal(status, 0, `the server ended with ${status ?? it.server.process.signalCode}; its log:\n${log}`);
  });
  return it;
}

// Fixed levels.
export function easy(games, envCount, more = {}) {
  return { games, envCount, options: { distributionMode: DistributionMode.EASY, randSeed: 5n }, ...more };
}

// Actions that differ by step and environment.
export function actionsOf(step, count) {
  return Int32Array.from({ length: count }, (_, i) => ((step * 31 + i * 17) % 16) - 1);
}

// The program fault-proxy: a faulty network (tests/service/robustness/fault_proxy.h). It ends with
// the test `t`, at the latest.
export class FaultProxy {
  static async start(t, target, seed, bytesBetweenFaults) {
    const process_ = spawn(process.env.PROCGEN_FAULT_PROXY, [target, `${seed}`, `${bytesBetweenFaults}`]);
    t.after(() => process_.kill());
    const lines = createInterface(process_.stdout);
    const [line] = await once(lines, "line");
    return Object.assign(new FaultProxy(), { process: process_, lines, address: line.replace("listening on ", "") });
  }

  // Stops it; returns the number of broken connections.
  async stop() {
    const line = once(this.lines, "line");
    this.process.stdin.end();
    return Number.parseInt((await line)[0], 10);
  }
}
