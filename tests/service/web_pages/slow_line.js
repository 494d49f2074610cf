// The proxy slow_line.py: a long or thin line to the server.

import { spawn } from "node:child_process";
import { once } from "node:events";
import { fileURLToPath } from "node:url";
import { createInterface } from "node:readline";

const PROGRAM = fileURLToPath(new URL("slow_line.py", import.meta.url));

export class SlowLine {
  #process;

  // Forwards a port of loopback to `address`, a URL; each direction takes `delayMs` and at most `bytesPerSecond`.
  static async open(address, delayMs, bytesPerSecond = Infinity) {
    const line = new SlowLine();
    const { hostname, port } = new URL(address);
    const args = [PROGRAM, hostname, port, delayMs, bytesPerSecond];
    line.#process = spawn(process.env.PROCGEN_PYTHON ?? "python3", args, { stdio: ["pipe", "pipe", "inherit"] });
    const [listening] = await once(createInterface(line.#process.stdout), "line");
    line.#process.unref();  // A test that fails before it closes the line must not keep the process alive.
    line.#process.stdin.unref();
    line.#process.stdout.unref();
    line.web = `http://127.0.0.1:${listening}`;
    return line;
  }

  close() {
    this.#process.stdin.end();
  }
}
