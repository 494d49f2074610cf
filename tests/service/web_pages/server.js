// procgen-server with its pages, and learners.

import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { once } from "node:events";
import { mkdtempSync } from "node:fs";
import { rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { createInterface } from "node:readline";
import { after, before } from "node:test";
import { fileURLToPath } from "node:url";

// Processes that have not ended.
const running = new Set();
process.on("exit", () => running.forEach((child) => child.kill("SIGKILL")));

// A test that fails before it ends a process must not wait for it.
function release(child) {
  running.add(child);
  child.once("exit", () => running.delete(child));
  for (const handle of [child, ...child.stdio]) {
    handle?.unref();
  }
}

// A new folder, which is removed after the tests of a file.
export function withFolder() {
  const folder = mkdtempSync(join(tmpdir(), "procgen-web-"));
  after(() => rm(folder, { recursive: true }));
  return folder;
}

// A server for the tests of a file.
export function withServer(...flags) {
  const server = new Server();
  before(() => {
    server.opened = server.open(...flags);
    return server.opened;
  });
  after(async () => assert.equal(await server.stop(), 0));
  return server;
}

const LEARNER = fileURLToPath(new URL("learner.py", import.meta.url));

// A server on loopback, on ports that the system chooses unless `flags` sets them.
export class Server {
  // Those that step a pool on it.
  learners = new Set();
  // Node does not wait for a hook before it begins the next.
  opened = Promise.resolve();

  static async start(...flags) {
    const server = new Server();
    await server.open(...flags);
    return server;
  }

  async open(...flags) {
    const args = ["--address=127.0.0.1:0", "--web_address=127.0.0.1:0", "--workers=1", ...flags];
    this.process = spawn(process.env.PROCGEN_SERVER_BINARY, args, { stdio: ["ignore", "pipe", "pipe"] });
    const lines = [];
    const exited = once(this.process, "exit").then(() => {
      throw new Error(`procgen-server ended:\n${lines.join("\n")}`);
    });
    exited.catch(() => undefined);
    const listening = new Promise((resolve) => {
      createInterface(this.process.stderr).on("line", (line) => {
        lines.push(line);
        const web = /event=listening .*\bweb=(\S+[^/\s])/.exec(line);
        if (web) {
          resolve(web[1]);
        }
      });
    });
    const [line] = await Promise.race([once(createInterface(this.process.stdout), "line"), exited]);
    this.address = line.replace("listening on ", "");
    this.web = await Promise.race([listening, exited]);
    release(this.process);
  }

  // The URL of a page.
  page(path = "/") {
    return `${this.web}${path}`;
  }

  // Stops the server after its learners; returns its exit status.
  async stop() {
    await Promise.all([...this.learners].map((learner) => learner.stop()));
    this.process.ref();
    const exited = once(this.process, "exit");
    this.process.kill("SIGTERM");
    return (await exited)[0];
  }
}

// A pool of a learner in Python, which takes the steps of the test.
export class Pool {
  #process;
  #lines;

  // `options`: those of procgen_client.Pool. `variables`: of the learner's environment, such as its token.
  static async open(server, games, envCount, options = {}, variables = {}) {
    await server.opened;
    const pool = new Pool();
    const values = { games, env_count: envCount, distribution_mode: "easy", rand_seed: 3, ...options };
    pool.#process = spawn(process.env.PROCGEN_PYTHON, [LEARNER, server.address, JSON.stringify(values)],
      { stdio: ["pipe", "pipe", "inherit"], env: { ...process.env, ...variables } });
    pool.#process.stdin.on("error", () => undefined);  // The learner has ended, which the next line reports.
    pool.#lines = createInterface(pool.#process.stdout)[Symbol.asyncIterator]();
    pool.name = await pool.#nextLine();
    release(pool.#process);
    return pool;
  }

  // Steps all environments; returns the SHA-256 of the observations. `more`: further arguments of procgen_client.Pool.step.
  step(actions, more = {}) {
    this.#process.stdin.write(`${JSON.stringify({ actions, ...more })}\n`);
    return this.#nextLine();
  }

  // Closes the pool.
  async close() {
    this.#process.ref();
    const exited = once(this.#process, "exit");
    this.#process.stdin.end();
    const [status] = await exited;
    if (status !== 0) {
      throw new Error(`the learner of ${this.name} ended with ${status}`);
    }
  }

  // Kills the learner, which ends the pool.
  abandon() {
    this.#process.kill("SIGKILL");
  }

  async #nextLine() {
    const { value, done } = await this.#lines.next();
    if (done) {
      throw new Error("the learner ended");
    }
    return value;
  }
}

// A learner that steps a pool with random actions until stop().
export class Learner {
  #isStopped = false;
  stepCount = 0;

  // `poolId`: the id of its pool.
  static async start(server, poolId, games, envCount, variables = {}) {
    const learner = new Learner();
    learner.server = server;
    learner.pool = await Pool.open(server, games, envCount, { pool_id: poolId }, variables);
    learner.running = learner.#run(envCount);
    learner.running.catch(() => undefined);  // stop() reports it.
    server.learners.add(learner);
    return learner;
  }

  // Ends a learner whose server is about to be killed.
  abandon() {
    this.server.learners.delete(this);
    this.#isStopped = true;
    this.pool.abandon();
  }

  async stop() {
    this.server.learners.delete(this);
    this.#isStopped = true;
    await this.running;
    await this.pool.close();
  }

  // Most actions go right, as with a partly trained policy. At times all environments change their action.
  async #run(envCount) {
    let actions;
    for (; !this.#isStopped; this.stepCount += 1) {
      const step = this.stepCount;
      if (step % 8 === 0) {
        actions = Array.from({ length: envCount }, (_, i) => (((step / 8) * 7 + i * 5) % 3 ? 7 : (step + i) % 15));
      }
      await this.pool.step(actions);
      await new Promise((resolve) => { setTimeout(resolve, 10); });
    }
  }
}
