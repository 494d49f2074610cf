// PoolResource: the calls of a pool beside its stream.

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

// Default of the server's largest response, in bytes.
export const responseBytesDefault = 4 * 1024 * 1024;
// Upper bound of a response of frames without the pixels, in bytes: once, and for each frame.
const framesOverheadBytes = 4096;
const frameOverheadBytes = 64;
// Default number of environments to watch.
const watchedDefault = 16;
// Upper bound of a state's overhead in a request, in bytes: a tag and a length.
const stateOverheadBytes = 8;

export interface CloneSource {
  // Source pool, or its name. Absent: this pool (with sourceServer: the pool of the same name
  // there).
  sourcePool?: PoolResource | string;
  // Address of its server, as this pool's server reaches it. Absent: the same server.
  sourceServer?: string;
}

export interface WatchOptions {
  // Side of the square frames in pixels, in [16, 2048]; 64: the agent's observation, pixel by
  // pixel. Default: 256.
  sizePx?: number;
  // Maximum number of responses per second, in (0, 60]. Default: 15.
  framesPerSecondMax?: number;
  // Cancels the call, which then throws CancelledError.
  signal?: AbortSignal;
}

// A pool's calls beside the stream. The server executes each between two requests of the pool's
// stream. Calls that save, restore or clone states throw FailedPreconditionError while requests of
// this object are unanswered.
export abstract class PoolResource {
  // Resource name, e.g. "pools/7".
  readonly name: string;
  // The spec of the pool, every default filled in, including a randSeed that the server drew.
  readonly spec: PoolSpec;
  // Shape of one environment's observation, [64, 64, 3] by default.
  readonly observationShape: readonly number[];
  // Bytes of one observation, F.
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

  // Returns snapshots of environments (default: all), in this order. A snapshot can be restored in
  // any environment of the same game on any server, which then continues identically, bit for bit.
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

  // Restores snapshots: an array with one for each environment, or a Map by environment. All or
  // nothing if they fit in one request (Limits.requestBytesMax). Otherwise several requests are
  // sent, and those before an error stay restored.
  async restoreStates(
    states: readonly Uint8Array[] | ReadonlyMap<number, Uint8Array>,
    options?: CallOptions,
  ): Promise<void> {
    this.requireNothingInFlight();
    if (!(states instanceof Map) && (states as readonly Uint8Array[]).length !== this.envCount) {
      throw new InvalidArgumentError(
        `states has ${(states as readonly Uint8Array[]).length} entries; there are ${this.envCount} environments (use a ` +
          "Map to restore some)",
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

  // Copies states to environments of this pool, by pairs [source, target]. All or nothing; all
  // sources are read before any target is written.
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

  // Returns an episode of an environment: the last that ended, or the current one. Episode in
  // proto/procgen/v1/states.proto documents how to replay it. Throws FailedPreconditionError: no
  // episode has ended yet, or the next has not started.
  async getEpisode(environment: number, selector = EpisodeSelector.LAST, options?: CallOptions): Promise<Episode> {
    return this.episode({ environment, selector }, options);
  }

  // Returns an episode of an environment that ended, by its fingerprint (Batch.fingerprints), which
  // is not 0. Throws NotFoundError: the server has not this episode, or not any more: it has those of
  // a pool's last 1,000, or fewer if they are long.
  async findEpisode(environment: number, fingerprint: bigint, options?: CallOptions): Promise<Episode> {
    return this.episode({ environment, fingerprint: BigInt.asIntN(64, fingerprint) }, options);
  }

  private async episode(
    which: { environment: number; selector?: EpisodeSelector; fingerprint?: bigint },
    options?: CallOptions,
  ): Promise<Episode> {
    const request = { pool: this.name, ...which };
    const episode = await this.connection.unary(StateService.method.getEpisode, request, options);
    if (episode.environment !== which.environment) {
      throw new InternalError(`the server's answer: an episode of environment ${episode.environment}, expected: ${which.environment}`);
    }
    return episode;
  }

  // Restarts the pool's lease. `leaseSeconds`: its new duration; default: unchanged.
  async renew(leaseSeconds?: number, options?: CallOptions): Promise<void> {
    const leaseDuration = leaseSeconds === undefined ? undefined : durationOf(leaseSeconds);
    await this.connection.unary(PoolService.method.renewPool, { name: this.name, leaseDuration }, options);
  }

  // Renders environments (default: all) for people: RGB, top row first, `sizePx` pixels a side, 16
  // to 2048.
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

  // Yields frames of environments (default: the first 16; at most 64) now, and again after each
  // change, at a bounded rate, without slowing the learner. A slow loop skips intermediate frames.
  // Throws AbortedError when the pool is deleted or its lease expires, and UnavailableError when
  // the server stops or the connection breaks. Leaving the loop ends the call.
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
      // No more than needed, because a server may have a low limit. 0: the default.
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
    throw new InvalidArgumentError(`sizePx is ${sizePx}, allowed: 16 to 2048`);
  }
}

function durationOf(seconds: number): { seconds: bigint; nanos: number } {
  if (!Number.isFinite(seconds)) {
    throw new InvalidArgumentError(`leaseSeconds is ${seconds}, allowed: a finite number`);
  }
  const whole = Math.trunc(seconds);
  return { seconds: BigInt(whole), nanos: Math.round((seconds - whole) * 1e9) };
}
