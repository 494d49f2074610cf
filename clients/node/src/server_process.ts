// A server of one's own, on this machine.

import { spawn, type ChildProcess } from "node:child_process";
import { once } from "node:events";
import { createInterface } from "node:readline";
import { UnavailableError } from "./errors.js";
import { startTimeoutDefaultMs, stopTimeoutDefaultMs } from "./timing.js";

export interface ServerProcessOptions {
  // The program. Default: what PROCGEN_SERVER_BINARY says, else procgen-server in PATH.
  binary?: string;
  // More flags, e.g. ["--workers=2"]; `procgen-server --help` tells them all.
  flags?: readonly string[];
  // How long to wait for it to listen. Default: 30 000.
  startTimeoutMs?: number;
}

// A procgen-server that is started, on a port of loopback that the system chooses unless a flag says otherwise, and stopped
// by stop(). Its log lines are thrown away.
export class ServerProcess {
  private constructor(
    // Where it listens, for connect.
    readonly address: string,
    readonly process: ChildProcess,
  ) {}

  static async start({ binary, flags = [], startTimeoutMs = startTimeoutDefaultMs }: ServerProcessOptions = {}): Promise<ServerProcess> {
    const program = binary ?? (process.env["PROCGEN_SERVER_BINARY"] || "procgen-server");
    const child = spawn(program, ["--address=127.0.0.1:0", ...flags], { stdio: ["ignore", "pipe", "ignore"] });
    const timer = setTimeout(() => child.kill("SIGKILL"), startTimeoutMs);
    try {
      return new ServerProcess(await addressOf(child, program), child);
    } finally {
      clearTimeout(timer);
    }
  }

  // Asks it to drain and end, and waits; kills it after a while. Gives its exit status; stopping again gives that again.
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
  // It writes the address that it is bound to on its standard output, and nothing else.
  const lines = createInterface(child.stdout!);
  const [line] = (await Promise.race([once(lines, "line"), failed])) as [string];
  failed.catch(() => undefined);
  return line.replace(/^listening on /, "").trim();
}
