// Pool: a pool of environments on a server, and the stream that steps it.

import type { MessageInitShape } from "@bufbuild/protobuf";
import { assemble, type Batch, type Part } from "./batch.js";
import { aborted, throwIfAborted, type Connection } from "./connection.js";
import { FailedPreconditionError, InvalidArgumentError, NotFoundError, UnavailableError } from "./errors.js";
import type { Limits } from "./generated/procgen/v1/catalog_pb.js";
import { Encoding, PoolService, type LevelSamplerSchema, type Pool as PoolMessage } from "./generated/procgen/v1/pools_pb.js";
import { Observation, type ResetSchema } from "./generated/procgen/v1/step_pb.js";
import { PoolResource, responseBytesDefault } from "./pool_resource.js";
import { Stream, type RequestBody } from "./stream.js";

const actionMin = -1;
const actionMax = 14;
// Upper bound of a response for one environment without its observations, in bytes.
const rowOverheadBytes = 1024;
// Bounds of the default chunk count: smaller chunks, in bytes of observations, cost more than they
// save; more chunks save nothing.
const chunkBytesMin = 2 * 1024 * 1024;
const defaultChunkCountMax = 4;

// Options of a pool's stream.
export interface PoolOptions {
  // Maximum number of unanswered requests. Default: 2.
  requestsInFlightMax?: number;
  // Number of responses to a step of the whole pool (Step.chunk_count), 1 to 64. Default: one for
  // each 2 MiB of observations, 1 to 4.
  chunkCount?: number;
}

export interface AttachOptions {
  // Ends another client's stream, if one is attached. Default: false, a FailedPreconditionError
  // then.
  takeOver?: boolean;
  // Largest response, in bytes. Default: 4 MiB, or more if one environment needs it.
  responseBytesMax?: number;
  signal?: AbortSignal;
}

export interface SliceOptions {
  // Index of the first environment of the slice. Default: 0.
  firstEnv?: number;
  // Number of environments. Default: all from firstEnv to the end of the pool.
  envCount?: number;
  // false: observations are not rendered or sent, which is many times faster. Default: true.
  observe?: boolean;
  // Cancels the wait for the answer and ends the stream; the request may still be executed. The
  // next request attaches again with takeOver.
  signal?: AbortSignal;
}

export type Reset = MessageInitShape<typeof ResetSchema>;

export interface StepOptions extends SliceOptions {
  // Number of times that the action is taken, in [1, 1000]; an environment stops early when it
  // completes its level or its episode ends. Default: 1.
  repeatCount?: number;
  // Also return the last observation of each episode that ends. Useful with AutoresetMode.SAME_STEP
  // only. Default: false.
  finalObservations?: boolean;
  // Seed of the next level by environment.
  nextLevels?: ReadonlyMap<number, number>;
  // Environments that start a new episode in place of being stepped.
  resets?: readonly Reset[];
}

export interface RolloutOptions extends StepOptions {
  // Number of steps. Default: unlimited.
  stepCount?: number;
}

// A pool. Created by Client.createPool or Client.getPool.
//
// The first request attaches to the pool: no other client can step it until detach or close. Up to
// requestsInFlightMax requests may be sent before their answers, which arrive in order. After a
// broken connection the pool attaches again and resends unanswered requests. An error of the server
// ends the stream, and outstanding answers are lost. The environments are then in the state before
// the failed request, and the next request attaches again.
export class Pool extends PoolResource {
  #requestsInFlightMax: number;
  readonly #chunkCount: number;
  readonly #reconnectTimeoutMs: number;
  #deletesOnClose: boolean;
  #stream: Promise<Stream> | undefined;
  #inFlight = 0;
  #closed = false;
  #abandoned = false; // The last stream was cancelled, which the server may not have detected yet.

  // Used by Client.createPool and Client.getPool.
  constructor(
    connection: Connection,
    message: PoolMessage,
    of: { limits: Limits; reconnectTimeoutMs: number; deletesOnClose: boolean } & PoolOptions,
  ) {
    super(connection, message, of.limits);
    this.#requestsInFlightMax = of.requestsInFlightMax ?? 2;
    this.#chunkCount = inRange("chunkCount", of.chunkCount ?? this.#defaultChunkCount(), 1, 64);
    this.#reconnectTimeoutMs = of.reconnectTimeoutMs;
    this.#deletesOnClose = of.deletesOnClose;
  }

  // Number of unanswered requests.
  get inFlight(): number {
    return this.#inFlight;
  }

  get requestsInFlightMax(): number {
    return this.#requestsInFlightMax;
  }

  // Steps a slice (default: the whole pool). Actions are in [-1, 15), one for each environment of
  // the slice; -1 does nothing and ends the episode.
  async step(actions: ArrayLike<number>, options: StepOptions = {}): Promise<Batch> {
    const { observe = true, repeatCount = 1, nextLevels, resets = [] } = options;
    const slice = this.#slice(options);
    if (actions.length !== slice.envCount) {
      throw new InvalidArgumentError(
        `actions has ${actions.length} entries; ${this.name} has ${slice.envCount} environments from ` +
          `${slice.firstEnv} on (firstEnv and envCount choose a slice)`,
      );
    }
    const value = {
      slice,
      actions: checkedActions(actions),
      repeatCount: inRange("repeatCount", repeatCount, 1, 1000),
      observation: observation(observe),
      withFinalObservations: options.finalObservations ?? false,
      chunkCount: observe && actions.length === this.envCount ? this.#chunkCount : 0,
      nextLevels: Array.from(nextLevels ?? [], ([environment, levelSeed]) => ({ environment, levelSeed })),
      resets: [...resets],
    };
    return this.#batch({ case: "step", value }, options.signal);
  }

  // Returns the current values of a slice, e.g. the first observations, and changes nothing.
  // Rewards and episode ends repeat those of the last step: do not sum them.
  async observe(options: SliceOptions = {}): Promise<Batch> {
    const value = { slice: this.#slice(options), observation: observation(options.observe ?? true) };
    return this.#batch({ case: "observe", value }, options.signal);
  }

  // Starts new episodes in some environments of a slice (default: all), and returns the slice.
  async reset(resets?: readonly Reset[], options: SliceOptions = {}): Promise<Batch> {
    const slice = this.#slice(options);
    const all = () =>
      Array.from({ length: slice.envCount }, (_, i) => ({ environment: slice.firstEnv + i }));
    const value = { slice, resets: [...(resets ?? all())], observation: observation(options.observe ?? true) };
    return this.#batch({ case: "reset", value }, options.signal);
  }

  // Replaces the pool's level sampler, from each environment's next choice of a level.
  async setLevelSampler(
    value: MessageInitShape<typeof LevelSamplerSchema>,
    { signal }: { signal?: AbortSignal } = {},
  ): Promise<void> {
    await this.#request({ case: "levelSampler", value }, signal);
  }

  // Yields the current batch, and then one after each step with the policy's actions:
  //     for await (const batch of pool.rollout(policy)) { ... }
  async *rollout(
    policy: (batch: Batch) => ArrayLike<number> | Promise<ArrayLike<number>>,
    { stepCount = Infinity, ...options }: RolloutOptions = {},
  ): AsyncGenerator<Batch, void, void> {
    const { firstEnv, envCount, observe, signal } = options;
    let batch = await this.observe({ firstEnv, envCount, observe, signal });
    yield batch;
    for (let step = 0; step < stepCount; step += 1) {
      batch = await this.step(await policy(batch), options);
      yield batch;
    }
  }

  // Attaches to the pool. Optional: the first request does it.
  async attach({ takeOver = false, responseBytesMax, signal }: AttachOptions = {}): Promise<void> {
    await (this.#stream ??= this.#open(takeOver, responseBytesMax ?? this.#responseBytesMax(), signal));
  }

  // Detaches after all requests are answered, so that another client can attach.
  async detach(): Promise<void> {
    const stream = this.#stream;
    this.#stream = undefined;
    await (await stream?.catch(() => undefined))?.close();
  }

  // Detaches, and deletes the pool if createPool created it. Idempotent.
  async close(): Promise<void> {
    if (this.#closed) {
      return;
    }
    this.#closed = true;
    await this.detach();
    if (this.#deletesOnClose && !this.connection.closed) {
      await this.#delete();
    }
  }

  protected override requireNothingInFlight(): void {
    if (this.#inFlight > 0) {
      throw new FailedPreconditionError(`${this.#inFlight} requests to ${this.name} are unanswered: await them first`);
    }
  }

  async #batch(body: RequestBody, signal?: AbortSignal): Promise<Batch> {
    return assemble(await this.#request(body, signal), this.observationShape);
  }

  async #request(body: RequestBody, signal?: AbortSignal): Promise<Part[]> {
    throwIfAborted(signal);
    if (this.#inFlight >= this.#requestsInFlightMax) {
      throw new FailedPreconditionError(
        `${this.#inFlight} requests to ${this.name} are unanswered, of at most ${this.#requestsInFlightMax}: await one first`,
      );
    }
    this.#inFlight += 1;
    // All requests wait for the same promise, so they are sent in the order of these calls.
    const opening = (this.#stream ??= this.#open(false, this.#responseBytesMax()));
    let abort: (() => void) | undefined;
    try {
      const stream = await opening;
      throwIfAborted(signal);
      abort = () => {
        this.#abandoned = true;
        stream.drop(aborted(signal!));
      };
      signal?.addEventListener("abort", abort, { once: true });
      return await stream.send(body);
    } catch (error) {
      if (isLost(error)) {
        this.#deletesOnClose = false; // By then its name may be another pool's.
      }
      const stream = await opening.catch(() => undefined);
      if (this.#stream === opening && (stream?.over ?? true)) {
        this.#stream = undefined;
      }
      throw error;
    } finally {
      this.#inFlight -= 1;
      if (abort !== undefined) {
        signal?.removeEventListener("abort", abort);
      }
    }
  }

  async #open(takeOver: boolean, responseBytesMax: number, signal?: AbortSignal): Promise<Stream> {
    try {
      if (this.#closed) {
        throw new FailedPreconditionError(`${this.name} was closed by this client`);
      }
      const attach = {
        pool: this.name,
        requestsInFlightMax: this.#requestsInFlightMax,
        takeOver: takeOver || this.#abandoned,
        responseBytesMax: BigInt(responseBytesMax),
      };
      const stream = await Stream.open(this.connection, attach, this.message, this.#reconnectTimeoutMs, signal);
      this.#abandoned = false;
      this.#requestsInFlightMax = stream.attached.requestsInFlightMax;
      return stream;
    } catch (error) {
      this.#stream = undefined;
      throw error;
    }
  }

  async #delete(): Promise<void> {
    try {
      await this.connection.unary(PoolService.method.deletePool, { name: this.name });
    } catch (error) {
      if (!isLost(error)) {
        throw error;
      }
    }
  }

  #defaultChunkCount(): number {
    const count = Math.floor((this.envCount * this.observationBytes) / chunkBytesMin);
    return Math.min(Math.max(count, 1), defaultChunkCountMax);
  }

  // Returns 0, the server's default, or more if one environment needs it.
  #responseBytesMax(): number {
    // An encoded observation takes at most 1.5 times its size; a final one is never encoded.
    const sent = this.spec.encoding === Encoding.RAW ? this.observationBytes : this.observationBytes * 1.5;
    const row = Math.ceil(sent) + this.observationBytes + rowOverheadBytes;
    return row <= responseBytesDefault ? 0 : row;
  }

  #slice({ firstEnv = 0, envCount = this.envCount - firstEnv }: SliceOptions) {
    inRange("firstEnv", firstEnv, 0, this.envCount - 1);
    if (envCount < 1 || firstEnv + envCount > this.envCount) {
      throw new InvalidArgumentError(
        `envCount is ${envCount} from environment ${firstEnv}; ${this.name} has ${this.envCount} environments`,
      );
    }
    return { firstEnv, envCount };
  }
}

// Whether an error means that the pool or the server is gone.
function isLost(error: unknown): boolean {
  return error instanceof NotFoundError || error instanceof UnavailableError;
}

function checkedActions(actions: ArrayLike<number>): number[] {
  return Array.from(actions, (action, i) => {
    if (!Number.isInteger(action) || action < actionMin || action > actionMax) {
      throw new InvalidArgumentError(`actions[${i}] is ${action}, allowed: ${actionMin} to ${actionMax}`);
    }
    return action;
  });
}

function observation(observe: boolean): Observation {
  return observe ? Observation.FRAME : Observation.NONE;
}

function inRange(name: string, given: number, least: number, most: number): number {
  if (!Number.isInteger(given) || given < least || given > most) {
    throw new InvalidArgumentError(`${name} is ${given}, allowed: ${least} to ${most}`);
  }
  return given;
}
