// ServerProcess: a local server.

import { spawn, type ChildProcess } from "node:child_process";
import { once } from "node:events";
import { closeSync, openSync } from "node:fs";
import { createInterface } from "node:readline";
import { UnavailableError } from "./errors.js";
import { startTimeoutDefaultMs, stopTimeoutDefaultMs } from "./timing.js";

export interface ServerProcessOptions {
  // The program. Default: PROCGEN_SERVER_BINARY, else procgen-server in PATH.
  binary?: string;
  // More flags, e.g. ["--workers=2"]; `procgen-server --help` lists them.
  flags?: readonly string[];
  // File for its log. Default: the log is discarded.
  logPath?: string;
  // Time that it has until it listens, in milliseconds. Default: 30 000.
  startTimeoutMs?: number;
}

// A procgen-server process. It listens on a free port of 127.0.0.1 unless a flag sets another
// address.
export class ServerProcess {
  private constructor(
    // Its address, for connect.
    readonly address: string,
    readonly process: ChildProcess,
  ) {}

  // Starts a server and waits until it listens. Throws UnavailableError: it cannot be started, or
  // has ended.
  static async start(options: ServerProcessOptions = {}): Promise<ServerProcess> {
    const { binary, flags = [], logPath, startTimeoutMs = startTimeoutDefaultMs } = options;
    const program = binary ?? (process.env["PROCGEN_SERVER_BINARY"] || "procgen-server");
    const log = logPath === undefined ? "ignore" : openSync(logPath, "w");
    const child = spawn(program, ["--address=127.0.0.1:0", ...flags], { stdio: ["ignore", "pipe", log] });
    if (typeof log === "number") {
      closeSync(log);
    }
    const timer = setTimeout(() => child.kill("SIGKILL"), startTimeoutMs);
    try {
      return new ServerProcess(await addressOf(child, program), child);
    } finally {
      clearTimeout(timer);
    }
  }

  // Stops the server: SIGTERM, and SIGKILL after the timeout. Returns its exit status, null if it
  // was killed. Idempotent.
  async stop(timeoutMs = stopTimeoutDefaultMs): Promise<number | null> {
    if (this.process.exitCode === null && this.process.signalCode === null) {
      const exited = once(this.process, "exit");
      const timer = setTimeout(() => this.process.kill("SIGKILL"), timeoutMs);
      this.process.kill("SIGTERM");
      await exited;
      clearTimeout(timer);
    }
    return this.process.exitCode;
  }
}

async function addressOf(child: ChildProcess, program: string): Promise<string> {
  const failed = new Promise<never>((_, reject) => {
    child.once("error", (error) => {
      reject(new UnavailableError(`${program} cannot be started: ${error.message}`, { cause: error }));
    });
    child.once("exit", (code, signal) => reject(new UnavailableError(`${program} ended with ${code ?? signal}`)));
  });
  // Its standard output is one line with the address.
  const lines = createInterface(child.stdout!);
  const [line] = (await Promise.race([once(lines, "line"), failed])) as [string];
  failed.catch(() => undefined);
  return line.replace(/^listening on /, "").trim();
}
