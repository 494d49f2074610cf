// procgen-server with its pages, and learners.

import { spawn } from "node:child_process";
import { once } from "node:events";
import { createInterface } from "node:readline";
import { after } from "node:test";
import { connect, DistributionMode } from "../../../clients/node/dist/index.js";

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

// Nodes of a cluster on loopback, and a fleet server.
export class Fleet {
  nodes = new Map();  // by name
  #flags = [`--cluster=pages-${process.pid}`, `--cluster_domain=${process.pid % 100}`, "--cluster_peers=127.0.0.1"];

  static async start(...names) {
    const fleet = new Fleet();
    await Promise.all(names.map((name) => fleet.startNode(name)));
    fleet.front = await Server.start(...fleet.#flags, "--fleet", "--node_id=front");
    return fleet;
  }

  async startNode(name) {
    this.nodes.set(name, await Server.start(...this.#flags, `--node_id=${name}`));
  }

  // Stops a node; returns its exit status.
  async stopNode(name) {
    const node = this.nodes.get(name);
    this.nodes.delete(name);
    return node.stop();
  }

  // Stops all; returns the exit statuses.
  async stop() {
    const status = await this.front.stop();
    return [status, ...await Promise.all([...this.nodes.keys()].map((name) => this.stopNode(name)))];
  }
}

// Learners that are not stopped: those of failed tests must not keep the process alive.
const started = new Set();
after(() => started.forEach((learner) => learner.abandon()));

// A learner that steps a pool with random actions until stop().
export class Learner {
  #isStopped = false;

  // `poolId`: the id of its pool. `environment`: options of its environments.
  static async start(server, poolId, games, envCount, options = {}, environment = {}) {
    const learner = new Learner();
    learner.client = await connect(server.address, options);
    const spec = { games, envCount, options: { distributionMode: DistributionMode.EASY, randSeed: 3n, ...environment } };
    learner.pool = await learner.client.createPool(spec, { poolId });
    learner.running = learner.#run(envCount);
    started.add(learner);
    return learner;
  }

  // Ends a learner whose server is about to be killed.
  abandon() {
    this.#isStopped = true;
    this.running.catch(() => undefined);
    this.#close();
  }

  // Ends the steps; the pool stays.
  async pause() {
    this.#isStopped = true;
    await this.running;
  }

  async stop() {
    await this.pause();
    await this.pool.close();
    this.#close();
  }

  #close() {
    this.client.close();
    started.delete(this);
  }

  // Most actions go right, as with a partly trained policy. At times all environments change their action.
  async #run(envCount) {
    const actions = new Int32Array(envCount);
    for (let step = 0; !this.#isStopped; step += 1) {
      if (step % 8 === 0) {
        actions.forEach((_, i) => { actions[i] = ((step / 8) * 7 + i * 5) % 3 ? 7 : (step + i) % 15; });
      }
      await this.pool.step(actions);
      await new Promise((resolve) => { setTimeout(resolve, 10); });
    }
  }
}
