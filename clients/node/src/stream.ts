// One learner's hold of one pool: the stream of StepPool, which outlives its connections.

import { setTimeout as sleep } from "node:timers/promises";
import { create, toBinary, type MessageInitShape } from "@bufbuild/protobuf";
import type { ServiceError } from "@grpc/grpc-js";
import { status } from "@grpc/grpc-js";
import { partOf, type Part } from "./batch.js";
import { aborted, throwIfAborted, type Connection, type StepPoolCall } from "./connection.js";
import { decoderFor, type ObservationDecoder } from "./encoding.js";
import {
  AbortedError, CancelledError, DataLossError, fromServiceError, InternalError, InvalidArgumentError, ProcgenError,
  UnavailableError,
} from "./errors.js";
import {
  AttachSchema, StepPoolRequestSchema,
  type Attach, type Attached, type StepPoolRequest, type StepPoolResponse,
} from "./generated/procgen/v1/step_pb.js";
import type { Pool } from "./generated/procgen/v1/pools_pb.js";
import { backoffMaxMs, backoffMinMs } from "./timing.js";
import { checkAttached, checkPart } from "./validation.js";

// A server that drains says so, and that it is not to be asked again.
const drainsKey = "procgen-drains";
// So many responses of kinds that are not known are ignored before an answer.
const noticesMax = 1000;

// What is asked for, as the field `request` of a StepPoolRequest.
export type Asked = NonNullable<MessageInitShape<typeof StepPoolRequestSchema>["request"]>;

// The call ended because its connection broke, not by an answer of the server.
class BrokenConnection {
  constructor(readonly error: ProcgenError) {}
}

interface Unanswered {
  request: StepPoolRequest;
  parts: Part[];
  resolve: (parts: Part[]) => void;
  reject: (error: unknown) => void;
}

// Sends requests and receives their answers, in order. Where the connection breaks it attaches again and sends again what
// is unanswered, for at most `reconnectTimeoutMs`: the server keeps its answers meanwhile, so no step is lost or taken
// twice. After any other error the stream is over, and so are all requests without an answer.
export class Stream {
  // What the server answered to the first attach.
  attached!: Attached;

  readonly #connection: Connection;
  readonly #attach: Attach;
  readonly #pool: Pool; // As it is known.
  readonly #reconnectTimeoutMs: number;
  readonly #unanswered: Unanswered[] = [];
  #call: StepPoolCall | undefined;
  #decoder: ObservationDecoder | undefined;
  #nextSequenceNumber = 0;
  #resuming = false;
  #notices = 0; // Since the last answer.
  #over: unknown; // Why the stream is over, if it is.
  #whenEnded: (() => void) | undefined; // Where somebody closes it.

  private constructor(
    connection: Connection,
    attach: MessageInitShape<typeof AttachSchema>,
    pool: Pool,
    reconnectTimeoutMs: number,
  ) {
    this.#connection = connection;
    this.#pool = pool;
    this.#attach = create(AttachSchema, { ...attach, resumable: reconnectTimeoutMs > 0 });
    this.#reconnectTimeoutMs = reconnectTimeoutMs;
  }

  // Attaches; 0 for `reconnectTimeoutMs`: a broken connection ends the stream.
  static async open(
    connection: Connection,
    attach: MessageInitShape<typeof AttachSchema>,
    pool: Pool,
    reconnectTimeoutMs: number,
    signal?: AbortSignal,
  ): Promise<Stream> {
    throwIfAborted(signal);
    const stream = new Stream(connection, attach, pool, reconnectTimeoutMs);
    const abort = () => stream.#call?.cancel();
    signal?.addEventListener("abort", abort, { once: true });
    try {
      stream.attached = await stream.#open(false);
      stream.#decoder = decoderFor(stream.attached.pool!);
    } catch (error) {
      stream.drop(error);
      throw signal?.aborted ? aborted(signal) : error instanceof BrokenConnection ? error.error : error;
    } finally {
      signal?.removeEventListener("abort", abort);
    }
    stream.#nextSequenceNumber = Number(stream.attached.nextSequenceNumber);
    // Whoever has it when the connection breaks was this stream, as far as the server knows.
    stream.#attach.takeOver = true;
    return stream;
  }

  get over(): boolean {
    return this.#over !== undefined;
  }

  // Numbers a request and sends it; its answer has one part or more, or none if there is nothing to tell.
  send(asked: Asked): Promise<Part[]> {
    if (this.#over !== undefined) {
      return Promise.reject(this.#over);
    }
    const request = numbered(asked, this.#nextSequenceNumber);
    this.#nextSequenceNumber += 1;
    return new Promise((resolve, reject) => {
      this.#unanswered.push({ request, parts: [], resolve, reject });
      if (this.#call !== undefined && !this.#resuming) {
        this.#call.write(request);
      } else if (!this.#resuming) {
        void this.#resume(new UnavailableError("the connection broke")); // While nobody waited for an answer.
      }
    });
  }

  // Ends the stream once everything sent is answered.
  async close(): Promise<void> {
    if (this.#call !== undefined && !this.#resuming) {
      const ended = new Promise<void>((resolve) => (this.#whenEnded = resolve));
      this.#call.end();
      await ended;
    }
    this.drop(new CancelledError("the stream was closed"));
  }

  // Ends the stream at once; all requests without an answer end with `reason`.
  drop(reason: unknown): void {
    this.#over ??= reason;
    const call = this.#call;
    this.#call = undefined;
    call?.cancel();
    for (const { reject } of this.#unanswered.splice(0)) {
      reject(reason);
    }
    this.#whenEnded?.();
  }

  // Calls StepPool and attaches. Rejects with BrokenConnection where it may be tried again.
  #open(waitForReady: boolean): Promise<Attached> {
    return new Promise((resolve, reject) => {
      const call = this.#connection.stepPool(waitForReady);
      this.#call = call;
      let isAttached = false;
      const ended = (error?: ServiceError) => {
        if (call !== this.#call) {
          return;
        }
        this.#call = undefined;
        if (isAttached) {
          this.#ended(this.#why(error));
        } else {
          reject(this.#why(error));
        }
      };
      call.on("data", (response: StepPoolResponse) => {
        if (call !== this.#call) {
          return;
        }
        if (isAttached) {
          this.#receive(response);
        } else if (response.response.case === "attached") {
          try {
            checkAttached(response.response.value, this.#attach, this.#pool);
          } catch (error) {
            reject(error);
            return;
          }
          isAttached = true;
          resolve(response.response.value);
        } else {
          reject(new InternalError(`${this.#attach.pool} answered something else than that it is attached`));
        }
      });
      call.on("error", ended);
      call.on("status", ({ code }) => code === status.OK && ended());
      call.write(create(StepPoolRequestSchema, { request: { case: "attach", value: this.#attach } }));
    });
  }

  // Why a call ended: a BrokenConnection where the stream may go on.
  #why(error?: ServiceError): ProcgenError | BrokenConnection {
    const why =
      error === undefined
        ? new UnavailableError(`the server ended the stream of ${this.#attach.pool}`)
        : fromServiceError(error);
    // Without an error: the server took the connection's end for that of the stream.
    const isBroken = error === undefined || isBrokenConnection(error);
    return isBroken && this.#reconnectTimeoutMs > 0 ? new BrokenConnection(why) : why;
  }

  #ended(why: ProcgenError | BrokenConnection): void {
    if (this.#whenEnded !== undefined) {
      this.drop(new CancelledError("the stream was closed"));
    } else if (!(why instanceof BrokenConnection)) {
      this.drop(why);
    } else if (this.#unanswered.length > 0 && !this.#resuming) {
      void this.#resume(why.error);
    }
  }

  #receive(response: StepPoolResponse): void {
    if (response.response.case === undefined && response.sequenceNumber === 0n) {
      // Of a later server's kinds and no answer: clients ignore those.
      this.#notices += 1;
      if (this.#notices > noticesMax) {
        this.drop(new InternalError(`the server sends more than ${noticesMax} responses of unknown kinds, expected: an answer`));
      }
      return;
    }
    this.#notices = 0;
    const oldest = this.#unanswered[0];
    if (oldest === undefined || response.sequenceNumber !== oldest.request.sequenceNumber) {
      const expected = oldest === undefined ? "no request is unanswered" : `${oldest.request.sequenceNumber} is next`;
      this.drop(new InternalError(`${this.#attach.pool} answered request ${response.sequenceNumber}, where ${expected}`));
      return;
    }
    try {
      if (response.response.case === "batch") {
        const part = partOf(response.sequenceNumber, response.response.value);
        checkPart(part, oldest.request, oldest.parts, this.attached);
        oldest.parts.push(part);
        if (!part.last) {
          return;
        }
      } else if (response.response.case !== "ack" || oldest.request.request.case !== "levelSampler") {
        const kind = response.response.case ?? "a kind that is not known";
        throw new InternalError(`${this.#attach.pool} answered request ${response.sequenceNumber} with ${kind}`);
      }
      this.#decode(oldest.parts);
    } catch (error) {
      this.drop(error);
      return;
    }
    this.#unanswered.shift();
    oldest.resolve(oldest.parts);
  }

  // Decodes a whole answer: what was read of one whose connection broke comes again.
  #decode(parts: Part[]): void {
    for (const part of parts) {
      if (this.#decoder === undefined || part.arrays.observations.length === 0) {
        continue;
      }
      try {
        const { firstEnv, envCount, arrays } = part;
        arrays.observations = this.#decoder.decode(firstEnv, envCount, arrays.observations);
      } catch (error) {
        const answer = `the answer of ${this.#attach.pool} to request ${part.sequenceNumber}`;
        throw new DataLossError(`${answer}: ${(error as Error).message}`, { cause: error });
      }
    }
  }

  // Goes on with a new connection, or ends the stream by why that cannot be.
  async #resume(broken: ProcgenError): Promise<void> {
    this.#resuming = true;
    const deadline = performance.now() + this.#reconnectTimeoutMs;
    for (let backoff = backoffMinMs, why = broken; ; backoff = Math.min(2 * backoff, backoffMaxMs)) {
      const delay = backoff * (0.5 + Math.random());
      if (performance.now() + delay >= deadline) {
        const seconds = this.#reconnectTimeoutMs / 1000;
        this.drop(
          new UnavailableError(`the connection broke and could not be made again within ${seconds} s: ${why.message}`),
        );
        return;
      }
      await sleep(delay);
      try {
        if (this.#over !== undefined) {
          return;
        }
        this.#checkStandsWhereLeft(await this.#openBy(deadline));
      } catch (error) {
        if (error instanceof BrokenConnection) {
          why = error.error;
          continue;
        }
        this.drop(error);
        return;
      }
      if (this.#call !== undefined) {
        break;
      }
    }
    this.#resuming = false;
    for (const unanswered of this.#unanswered) {
      unanswered.parts = [];
      this.#call.write(unanswered.request);
    }
  }

  async #openBy(deadline: number): Promise<Attached> {
    // Not the call's own deadline, which would be that of the whole stream.
    let isLate = false; // Not asked of the clock: a timer may be some of a millisecond early.
    const timer = setTimeout(() => {
      isLate = true;
      this.#call?.cancel();
    }, Math.max(0, deadline - performance.now()));
    try {
      return await this.#open(true);
    } catch (error) {
      throw error instanceof ProcgenError && isLate ? new BrokenConnection(error) : error;
    } finally {
      clearTimeout(timer);
    }
  }

  #checkStandsWhereLeft(attached: Attached): void {
    const standsAt = Number(attached.nextSequenceNumber);
    const least = Number(this.#unanswered[0]?.request.sequenceNumber ?? this.#nextSequenceNumber);
    if (standsAt < least || standsAt > this.#nextSequenceNumber) {
      throw new AbortedError(
        `${this.#attach.pool} is at request ${standsAt}, and this stream left it between ${least} and ` +
          `${this.#nextSequenceNumber}: somebody else has stepped it, or it is another pool of the same name`,
      );
    }
  }
}

// A request with its number. A value that does not fit its field is an InvalidArgumentError, and costs no stream.
function numbered(asked: Asked, sequenceNumber: number): StepPoolRequest {
  try {
    const request = create(StepPoolRequestSchema, { sequenceNumber: BigInt(sequenceNumber), request: asked });
    toBinary(StepPoolRequestSchema, request);
    return request;
  } catch (error) {
    throw new InvalidArgumentError(`a request has a wrong value: ${(error as Error).message}`, { cause: error });
  }
}

function isBrokenConnection(error: ServiceError): boolean {
  if (error.code === status.UNAVAILABLE) {
    return error.metadata.get(drainsKey).length === 0;
  }
  // gRPC's words where a socket was reset in the midst of a stream.
  return error.code === status.UNKNOWN || (error.code === status.INTERNAL && error.details.includes("RST_STREAM"));
}
