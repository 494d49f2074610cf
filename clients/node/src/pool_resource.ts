// A pool as it lies on a server: what can be asked of it from beside its stream.

import type { Connection, CallOptions } from "./connection.js";
import { encoded } from "./connection.js";
import { InternalError, InvalidArgumentError } from "./errors.js";
import type { Limits } from "./generated/procgen/v1/catalog_pb.js";
import { PoolService, type Pool as PoolMessage, type PoolSpec } from "./generated/procgen/v1/pools_pb.js";
import {
  FrameFormat, RenderService,
  type Frame, type WatchPoolResponse,
} from "./generated/procgen/v1/render_pb.js";
import { checkFrames, checkStates } from "./validation.js";
import { EpisodeSelector, StateSchema, StateService, type Episode } from "./generated/procgen/v1/states_pb.js";

// What a server sends at most in one response unless told otherwise. In bytes.
export const responseBytesDefault = 4 * 1024 * 1024;
// What a response of frames has besides their pixels, at most: once, and for each. In bytes.
const framesOverheadBytes = 4096;
const frameOverheadBytes = 64;
// How many environments are watched where nobody tells which.
const watchedDefault = 16;
// What a state has in a request besides its own bytes, at most: a tag and a length.
const stateOverheadBytes = 8;

export interface CloneSource {
  // The pool that is read, or its name. Absent: this one (on another server: the one of the same name).
  sourcePool?: PoolResource | string;
  // Address of its server, as this pool's server can reach it. Absent: the same server.
  sourceServer?: string;
}

export interface WatchOptions {
  // Side of the square frames in pixels, in [16, 2048]; 64: what the agent sees, pixel by pixel. Default: 256.
  sizePx?: number;
  // Moments in a second at most, above 0 and at most 60. Default: 15.
  framesPerSecondMax?: number;
  // Ends the call with CancelledError.
  signal?: AbortSignal;
}

// These calls happen between two requests of whoever steps the pool. Those that save, restore or clone states are a
// FailedPreconditionError while requests of its own are unanswered.
export abstract class PoolResource {
  // Resource name, e.g. "pools/7".
  readonly name: string;
  // What the pool was made with, every default filled in (also a randSeed that the server drew).
  readonly spec: PoolSpec;
  // Shape of one environment's observation, [64, 64, 3] by default.
  readonly observationShape: readonly number[];
  // Bytes of one, F.
  readonly observationBytes: number;

  constructor(
    protected readonly connection: Connection,
    protected readonly message: PoolMessage,
    private readonly limits: Limits,
  ) {
    this.name = message.name;
    this.spec = message.spec!;
    this.observationShape = message.observationShape;
    this.observationBytes = message.observationBytes;
  }

  // Number of environments, N.
  get envCount(): number {
    return this.spec.envCount;
  }

  // Takes snapshots of environments (all, unless told which), in the order asked for. An environment that is put into one
  // goes on as this one does, bit for bit, in any pool of the same game on any server.
  async saveStates(environments?: readonly number[], options?: CallOptions): Promise<Uint8Array[]> {
    this.requireNothingInFlight();
    const snapshots: Uint8Array[] = [];
    if (environments?.length === 0) {
      return snapshots;
    }
    const wanted = environments ?? firstEnvs(this.envCount);
    const request = { pool: this.name, environments: [...(environments ?? [])], pageToken: "" };
    do {
      const page = await this.connection.unary(StateService.method.saveStates, request, options);
      checkStates(page, wanted, snapshots.length);
      snapshots.push(...page.states.map((state) => state.snapshot));
      request.pageToken = page.nextPageToken;
    } while (request.pageToken !== "");
    return snapshots;
  }

  // Puts environments into saved states: one for each environment, or some by environment. All or nothing, as long as they
  // fit one request of the server; more are sent in several, and those before one that is refused are restored.
  async restoreStates(
    states: readonly Uint8Array[] | ReadonlyMap<number, Uint8Array>,
    options?: CallOptions,
  ): Promise<void> {
    this.requireNothingInFlight();
    if (!(states instanceof Map) && (states as readonly Uint8Array[]).length !== this.envCount) {
      throw new InvalidArgumentError(
        `states has ${(states as readonly Uint8Array[]).length} entries; there are ${this.envCount} environments (a Map ` +
          "gives some of them theirs)",
      );
    }
    const overhead = this.name.length + stateOverheadBytes;
    let batch: { environment: number; snapshot: Uint8Array }[] = [];
    let bytes = overhead;
    const send = () =>
      this.connection.unary(StateService.method.restoreStates, { pool: this.name, states: batch }, options);
    for (const [environment, snapshot] of states.entries()) {
      const stateBytes = encoded(StateSchema, { environment, snapshot }).length + stateOverheadBytes;
      if (batch.length > 0 && bytes + stateBytes > this.limits.requestBytesMax) {
        await send();
        [batch, bytes] = [[], overhead];
      }
      batch.push({ environment, snapshot });
      bytes += stateBytes;
    }
    if (batch.length > 0) {
      await send();
    }
  }

  // Puts environments of this pool into the states of others: pairs of the environment that is read and the one that is
  // written. All or nothing; all are read before any is written.
  async cloneStates(
    pairs: Iterable<readonly [source: number, target: number]>,
    { sourcePool = "", sourceServer = "", ...options }: CloneSource & CallOptions = {},
  ): Promise<void> {
    this.requireNothingInFlight();
    const messages = Array.from(pairs, ([sourceEnvironment, targetEnvironment]) => ({
      sourceEnvironment,
      targetEnvironment,
    }));
    if (messages.length > 0) {
      const source = typeof sourcePool === "string" ? sourcePool : sourcePool.name;
      const request = { pool: this.name, sourcePool: source, sourceServer, pairs: messages };
      await this.connection.unary(StateService.method.cloneStates, request, options);
    }
  }

  // Tells what happened in an episode of an environment, the last that ended or the one under way, so that it can be played
  // again: the comments of Episode (proto/procgen/v1/states.proto) say how. FailedPreconditionError: none has ended yet, or
  // the next has not begun.
  async getEpisode(environment: number, selector = EpisodeSelector.LAST, options?: CallOptions): Promise<Episode> {
    const request = { pool: this.name, environment, selector };
    const episode = await this.connection.unary(StateService.method.getEpisode, request, options);
    if (episode.environment !== environment) {
      throw new InternalError(`the server's answer: an episode of environment ${episode.environment}, expected: ${environment}`);
    }
    return episode;
  }

  // Begins the pool's lease anew: its time to live while nobody steps it. `leaseSeconds`: its length from now on.
  async renew(leaseSeconds?: number, options?: CallOptions): Promise<void> {
    const leaseDuration = leaseSeconds === undefined ? undefined : durationOf(leaseSeconds);
    await this.connection.unary(PoolService.method.renewPool, { name: this.name, leaseDuration }, options);
  }

  // Draws environments for people (all, unless told which), in squares of sizePx pixels, 16 to 2048: RGB, top row first.
  async render(environments?: readonly number[], sizePx = 512, options?: CallOptions): Promise<Frame[]> {
    checkSizePx(sizePx);
    const wanted = environments ?? firstEnvs(this.envCount);
    const roomBytes = Math.min(responseBytesDefault, Number(this.limits.responseBytesMax)) - framesOverheadBytes;
    const atATime = Math.max(1, Math.floor(roomBytes / frameBytes(sizePx)));
    const frames: Frame[] = [];
    for (let begin = 0; begin < wanted.length; begin += atATime) {
      const request = this.#framesRequest(wanted.slice(begin, begin + atATime), sizePx);
      const rendered = await this.connection.unary(RenderService.method.renderEnvironments, request, options);
      checkFrames(rendered.frames, request.environments, sizePx);
      frames.push(...rendered.frames);
    }
    return frames;
  }

  // Shows environments (the first 16, unless told which; at most 64) while somebody steps them, and never slows who does: at
  // first as they are now, then as they are after something has changed, at a bounded rate. Who takes long between two
  // moments misses those in between. Ends with AbortedError when the pool is gone, and with UnavailableError when the server
  // stops or the connection breaks; leaving a loop over it ends the call.
  async *watch(
    environments?: readonly number[],
    { sizePx = 256, framesPerSecondMax = 15, signal }: WatchOptions = {},
  ): AsyncGenerator<WatchPoolResponse, void, void> {
    checkSizePx(sizePx);
    const wanted = environments ?? firstEnvs(Math.min(this.envCount, watchedDefault));
    const request = { ...this.#framesRequest(wanted, sizePx), framesPerSecondMax };
    for await (const moment of this.connection.serverStream(RenderService.method.watchPool, request, signal)) {
      checkFrames(moment.frames, wanted, sizePx);
      yield moment;
    }
  }

  protected abstract requireNothingInFlight(): void;

  #framesRequest(environments: readonly number[], sizePx: number) {
    const bytes = framesOverheadBytes + environments.length * frameBytes(sizePx);
    return {
      pool: this.name,
      environments: [...environments],
      sizePx,
      format: FrameFormat.RGB,
      // No more than they take, as a server may have a low limit. 0: what it sends by default.
      responseBytesMax: BigInt(bytes <= responseBytesDefault ? 0 : bytes),
    };
  }
}

function firstEnvs(count: number): number[] {
  return Array.from({ length: count }, (_, environment) => environment);
}

function frameBytes(sizePx: number): number {
  return 3 * sizePx ** 2 + frameOverheadBytes;
}

function checkSizePx(sizePx: number): void {
  if (!Number.isInteger(sizePx) || sizePx < 16 || sizePx > 2048) {
    throw new InvalidArgumentError(`sizePx is ${sizePx}; it is in [16, 2048]`);
  }
}

function durationOf(seconds: number): { seconds: bigint; nanos: number } {
  if (!Number.isFinite(seconds)) {
    throw new InvalidArgumentError(`a duration of ${seconds} seconds is none`);
  }
  const whole = Math.trunc(seconds);
  return { seconds: BigInt(whole), nanos: Math.round((seconds - whole) * 1e9) };
}
