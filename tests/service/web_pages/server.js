// procgen-server with its pages, and learners.

import { spawn } from "node:child_process";
import { once } from "node:events";
import { createInterface } from "node:readline";
import { fileURLToPath } from "node:url";

const LEARNER = fileURLToPath(new URL("learner.py", import.meta.url));

// A server on loopback, on ports that the system chooses unless `flags` sets them.
export class Server {
  static async start(...flags) {
    const server = new Server();
    const args = ["--address=127.0.0.1:0", "--web_address=127.0.0.1:0", "--workers=1", ...flags];
    server.process = spawn(process.env.PROCGEN_SERVER_BINARY, args, { stdio: ["ignore", "pipe", "pipe"] });
    const lines = [];
    const exited = once(server.process, "exit").then(() => {
      throw new Error(`procgen-server ended:\n${lines.join("\n")}`);
    });
    exited.catch(() => undefined);
    const listening = new Promise((resolve) => {
      createInterface(server.process.stderr).on("line", (line) => {
        lines.push(line);
        const web = /event=listening .*\bweb=(\S+[^/\s])/.exec(line);
        if (web) {
          resolve(web[1]);
        }
      });
    });
    const [line] = await Promise.race([once(createInterface(server.process.stdout), "line"), exited]);
    server.address = line.replace("listening on ", "");
    server.web = await Promise.race([listening, exited]);
    return server;
  }

  // The URL of a page.
  page(path = "/") {
    return `${this.web}${path}`;
  }

  // Stops the server; returns its exit status.
  async stop() {
    const exited = once(this.process, "exit");
    this.process.kill("SIGTERM");
    return (await exited)[0];
  }
}

// Pools that are not closed.
const open = new Set();
process.on("exit", () => open.forEach((pool) => pool.abandon()));

// A pool of a learner in Python, which takes the steps of the test.
export class Pool {
  #process;
  #lines;

  // `options`: those of procgen_client.Pool. `variables`: of the learner's environment, such as its token.
  static async open(server, games, envCount, options = {}, variables = {}) {
    const pool = new Pool();
    const values = { games, env_count: envCount, distribution_mode: "easy", rand_seed: 3, ...options };
    pool.#process = spawn(process.env.PROCGEN_PYTHON, [LEARNER, server.address, JSON.stringify(values)],
      { stdio: ["pipe", "pipe", "inherit"], env: { ...process.env, ...variables } });
    pool.#process.stdin.on("error", () => undefined);  // The learner has ended, which the next line reports.
    for (const handle of [pool.#process, pool.#process.stdin, pool.#process.stdout]) {
      handle.unref();  // A test that fails before it closes the pool must not keep the process alive.
    }
    pool.#lines = createInterface(pool.#process.stdout)[Symbol.asyncIterator]();
    open.add(pool);
    pool.name = await pool.#nextLine();
    return pool;
  }

  // Steps all environments; returns the SHA-256 of the observations. `more`: further arguments of procgen_client.Pool.step.
  step(actions, more = {}) {
    this.#process.stdin.write(`${JSON.stringify({ actions, ...more })}\n`);
    return this.#nextLine();
  }

  // Closes the pool.
  async close() {
    const exited = once(this.#process, "exit");
    this.#process.stdin.end();
    const [status] = await exited;
    open.delete(this);
    if (status !== 0) {
      throw new Error(`the learner of ${this.name} ended with ${status}`);
    }
  }

  // Kills the learner, which ends the pool.
  abandon() {
    this.#process.kill("SIGKILL");
    open.delete(this);
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
    learner.pool = await Pool.open(server, games, envCount, { pool_id: poolId }, variables);
    learner.running = learner.#run(envCount);
    learner.running.catch(() => undefined);  // stop() reports it.
    return learner;
  }

  // Ends a learner whose server is about to be killed.
  abandon() {
    this.#isStopped = true;
    this.pool.abandon();
  }

  async stop() {
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
