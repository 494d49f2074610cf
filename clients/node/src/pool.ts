// A pool of environments on a server, and the stream that steps it.

import type { MessageInitShape } from "@bufbuild/protobuf";
import { assemble, type Batch, type Part } from "./batch.js";
import { aborted, throwIfAborted, type Connection } from "./connection.js";
import { FailedPreconditionError, InvalidArgumentError, NotFoundError, UnavailableError } from "./errors.js";
import type { Limits } from "./generated/procgen/v1/catalog_pb.js";
import { Encoding, PoolService, type LevelSamplerSchema, type Pool as PoolMessage } from "./generated/procgen/v1/pools_pb.js";
import { Observation, type ResetSchema } from "./generated/procgen/v1/step_pb.js";
import { PoolResource, responseBytesDefault } from "./pool_resource.js";
import { Stream, type Asked } from "./stream.js";

const actionMin = -1;
const actionMax = 14;
// What a response for one environment has besides an observation and a final one, at most. In bytes.
const rowOverheadBytes = 1024;
// Chunks smaller than this, in bytes of observations, cost more than they save; and more of them than this save nothing.
const chunkBytesMin = 2 * 1024 * 1024;
const defaultChunkCountMax = 4;

// How a pool is held.
export interface PoolOptions {
  // How many requests may be unanswered. Default: 2.
  requestsInFlightMax?: number;
  // In how many chunks the whole pool is stepped, 1 to 64: while one is on its way, the next is stepped. Default: as many
  // as pay.
  chunkCount?: number;
}

export interface AttachOptions {
  // End another client's stream, if there is one.
  takeOver?: boolean;
  // Largest response that the server may send, in bytes. Default: 4 MiB, or what one environment's answer takes.
  responseBytesMax?: number;
  signal?: AbortSignal;
}

export interface SliceOptions {
  // Index of the slice's first environment. Default: 0.
  firstEnv?: number;
  // Number of its environments. Default: all from the first to the pool's last.
  envCount?: number;
  // false: no pictures are drawn or sent, which is many times faster.
  observe?: boolean;
  // Ends the stream while the answer is waited for; the request may have been carried out all the same. The next one
  // takes the pool over from it.
  signal?: AbortSignal;
}

export type Reset = MessageInitShape<typeof ResetSchema>;

export interface StepOptions extends Omit<SliceOptions, "envCount"> {
  // The same action is taken so many times, in [1, 1000]; an environment stops when its episode ends.
  repeatCount?: number;
  // Where an episode ends, its last picture is answered, too. Only of use with AutoresetMode.SAME_STEP.
  finalObservations?: boolean;
  // Level seeds by environment, to be played after the present levels.
  nextLevels?: ReadonlyMap<number, number>;
  // Environments that begin a new episode in place of being stepped.
  resets?: readonly Reset[];
}

export interface RolloutOptions extends StepOptions {
  // How many steps; endlessly by default.
  stepCount?: number;
}

// Made by Client.createPool or Client.getPool. The first request attaches to the pool: no other client can step it until
// detach or close. Requests may be sent ahead: up to requestsInFlightMax may be unanswered, and their answers come in
// order. Where the connection breaks, the pool attaches again by itself and sends again what is unanswered. After an error
// of the server the stream is over, answers that were still owed are lost, and the next request attaches anew; the
// environments stand as they did before the request at fault.
export class Pool extends PoolResource {
  #requestsInFlightMax: number;
  readonly #chunkCount: number;
  readonly #reconnectTimeoutMs: number;
  readonly #deletesOnClose: boolean;
  #stream: Promise<Stream> | undefined;
  #inFlight = 0;
  #closed = false;
  #abandoned = false; // The last stream was given up, which the server may not have noticed yet.

  // For Client; use its createPool or getPool.
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

  // Number of requests without an answer.
  get inFlight(): number {
    return this.#inFlight;
  }

  get requestsInFlightMax(): number {
    return this.#requestsInFlightMax;
  }

  // Steps each environment of a slice: as many as there are actions, each in [-1, 15); -1 does nothing and ends the episode.
  async step(actions: ArrayLike<number>, options: StepOptions = {}): Promise<Batch> {
    const { firstEnv = 0, observe = true, repeatCount = 1, nextLevels, resets = [] } = options;
    this.#checkSlice(firstEnv, actions.length, "actions");
    const value = {
      slice: { firstEnv, envCount: actions.length },
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

  // Tells how a slice stands and changes nothing: how a learner gets the first observations.
  // Rewards and ends are those of the last step again, not to be added up.
  async observe(options: SliceOptions = {}): Promise<Batch> {
    const value = { slice: this.#slice(options), observation: observation(options.observe ?? true) };
    return this.#batch({ case: "observe", value }, options.signal);
  }

  // Begins new episodes in some environments of a slice (all of it, unless told which), and tells how it stands.
  async reset(resets?: readonly Reset[], options: SliceOptions = {}): Promise<Batch> {
    const slice = this.#slice(options);
    const all = () =>
      Array.from({ length: slice.envCount }, (_, i) => ({ environment: slice.firstEnv + i }));
    const value = { slice, resets: [...(resets ?? all())], observation: observation(options.observe ?? true) };
    return this.#batch({ case: "reset", value }, options.signal);
  }

  // Replaces what chooses the levels; takes effect at each environment's next episode.
  async setLevelSampler(
    value: MessageInitShape<typeof LevelSamplerSchema>,
    { signal }: { signal?: AbortSignal } = {},
  ): Promise<void> {
    await this.#request({ case: "levelSampler", value }, signal);
  }

  // Gives how the pool stands and then, as long as it is asked for more, what the policy's actions lead to:
  //     for await (const batch of pool.rollout(policy)) { ... }
  async *rollout(
    policy: (batch: Batch) => ArrayLike<number> | Promise<ArrayLike<number>>,
    { stepCount = Infinity, ...options }: RolloutOptions = {},
  ): AsyncGenerator<Batch, void, void> {
    const { firstEnv, observe, signal } = options;
    let batch = await this.observe({ firstEnv, observe, signal });
    yield batch;
    for (let step = 0; step < stepCount; step += 1) {
      batch = await this.step(await policy(batch), options);
      yield batch;
    }
  }

  // Takes the pool for this object. Never necessary: the first request does so.
  async attach({ takeOver = false, responseBytesMax, signal }: AttachOptions = {}): Promise<void> {
    await (this.#stream ??= this.#open(takeOver, responseBytesMax ?? this.#responseBytesMax(), signal));
  }

  // Lets the pool go, so that another client can attach; once everything sent is answered.
  async detach(): Promise<void> {
    const stream = this.#stream;
    this.#stream = undefined;
    await (await stream?.catch(() => undefined))?.close();
  }

  // Detaches, and deletes the pool if createPool made it. Closing again does nothing.
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

  async #batch(asked: Asked, signal?: AbortSignal): Promise<Batch> {
    return assemble(await this.#request(asked, signal), this.observationShape);
  }

  async #request(asked: Asked, signal?: AbortSignal): Promise<Part[]> {
    throwIfAborted(signal);
    if (this.#inFlight >= this.#requestsInFlightMax) {
      throw new FailedPreconditionError(
        `${this.#inFlight} requests to ${this.name} are unanswered, of at most ${this.#requestsInFlightMax}: await one first`,
      );
    }
    this.#inFlight += 1;
    // Each request waits for the very same promise, so that they are sent in the order of these calls.
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
      return await stream.send(asked);
    } catch (error) {
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
      if (!(error instanceof NotFoundError || error instanceof UnavailableError)) {
        throw error; // Otherwise it is gone, or the server is.
      }
    }
  }

  #defaultChunkCount(): number {
    const count = Math.floor((this.envCount * this.observationBytes) / chunkBytesMin);
    return Math.min(Math.max(count, 1), defaultChunkCountMax);
  }

  // 0, for what servers send by default, or more where that has no room for a row.
  #responseBytesMax(): number {
    // An encoded observation may take half as much again; a final one is never encoded.
    const sent = this.spec.encoding === Encoding.RAW ? this.observationBytes : this.observationBytes * 1.5;
    const row = Math.ceil(sent) + this.observationBytes + rowOverheadBytes;
    return row <= responseBytesDefault ? 0 : row;
  }

  #slice({ firstEnv = 0, envCount = this.envCount - firstEnv }: SliceOptions) {
    this.#checkSlice(firstEnv, envCount, "environments");
    return { firstEnv, envCount };
  }

  #checkSlice(firstEnv: number, count: number, what: string): void {
    inRange("firstEnv", firstEnv, 0, this.envCount - 1);
    if (count < 1 || firstEnv + count > this.envCount) {
      throw new InvalidArgumentError(
        `${count} ${what} from environment ${firstEnv}; ${this.name} has ${this.envCount} environments`,
      );
    }
  }
}

function checkedActions(actions: ArrayLike<number>): number[] {
  return Array.from(actions, (action, i) => {
    if (!Number.isInteger(action) || action < actionMin || action > actionMax) {
      throw new InvalidArgumentError(`actions[${i}] is ${action}; actions are ${actionMin} ... ${actionMax}`);
    }
    return action;
  });
}

function observation(observe: boolean): Observation {
  return observe ? Observation.FRAME : Observation.NONE;
}

function inRange(name: string, given: number, least: number, most: number): number {
  if (!Number.isInteger(given) || given < least || given > most) {
    throw new InvalidArgumentError(`${name} is ${given}; it is in [${least}, ${most}]`);
  }
  return given;
}
