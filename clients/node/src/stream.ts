// Stream: a StepPool stream that is resumed after broken connections.

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

// Trailing metadata of a server that drains, which must not be retried.
const drainsKey = "procgen-drains";
// Maximum number of responses of unknown kinds that are skipped before an answer.
const noticesMax = 1000;

// The field `request` of a StepPoolRequest.
export type RequestBody = NonNullable<MessageInitShape<typeof StepPoolRequestSchema>["request"]>;

// The call ended because its connection broke; a retry may succeed.
class BrokenConnection {
  constructor(readonly error: ProcgenError) {}
}

interface Unanswered {
  request: StepPoolRequest;
  parts: Part[];
  resolve: (parts: Part[]) => void;
  reject: (error: unknown) => void;
}

// Sends requests and receives their answers, in order. After a broken connection it attaches again
// and resends unanswered requests, for at most `reconnectTimeoutMs`. The server keeps its answers
// meanwhile, so no step is lost or executed twice. Any other error ends the stream and rejects all
// unanswered requests.
export class Stream {
  // Response to the first attach.
  attached!: Attached;

  readonly #connection: Connection;
  readonly #attach: Attach;
  readonly #pool: Pool; // As known before attaching.
  readonly #reconnectTimeoutMs: number;
  readonly #unanswered: Unanswered[] = [];
  #call: StepPoolCall | undefined;
  #decoder: ObservationDecoder | undefined;
  #nextSequenceNumber = 0;
  #resuming = false;
  #notices = 0; // Since the last answer.
  #over: unknown; // The error that ended the stream; undefined while it is open.
  #whenEnded: (() => void) | undefined; // Set by close.

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

  // Attaches. `reconnectTimeoutMs` 0: a broken connection ends the stream.
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
    // After a broken connection the attached stream is this one, which the server may not have
    // noticed.
    stream.#attach.takeOver = true;
    return stream;
  }

  get over(): boolean {
    return this.#over !== undefined;
  }

  // Sends a request with the next sequence number. Resolves to its responses; empty for an answer
  // without values.
  send(body: RequestBody): Promise<Part[]> {
    if (this.#over !== undefined) {
      return Promise.reject(this.#over);
    }
    const request = numbered(body, this.#nextSequenceNumber);
    this.#nextSequenceNumber += 1;
    return new Promise((resolve, reject) => {
      this.#unanswered.push({ request, parts: [], resolve, reject });
      if (this.#call !== undefined && !this.#resuming) {
        this.#call.write(request);
      } else if (!this.#resuming) {
        void this.#resume(new UnavailableError("the connection broke")); // It broke while no request was unanswered.
      }
    });
  }

  // Ends the stream after all requests are answered.
  async close(): Promise<void> {
    if (this.#call !== undefined && !this.#resuming) {
      const ended = new Promise<void>((resolve) => (this.#whenEnded = resolve));
      this.#call.end();
      await ended;
    }
    this.drop(new CancelledError("the stream was closed"));
  }

  // Ends the stream at once, and rejects all unanswered requests with `reason`.
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

  // Calls StepPool and attaches. Rejects with BrokenConnection if a retry may succeed.
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
          reject(new InternalError(`the first response of ${this.#attach.pool} does not answer attach`));
        }
      });
      call.on("error", ended);
      call.on("status", ({ code }) => code === status.OK && ended());
      call.write(create(StepPoolRequestSchema, { request: { case: "attach", value: this.#attach } }));
    });
  }

  // Returns why a call ended: a BrokenConnection if the stream can be resumed.
  #why(error?: ServiceError): ProcgenError | BrokenConnection {
    const why =
      error === undefined
        ? new UnavailableError(`the server ended the stream of ${this.#attach.pool}`)
        : fromServiceError(error);
    // Without an error: the server took the end of the connection for a half-close.
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
      // A kind that only newer clients know, and that answers no request: ignored.
      this.#notices += 1;
      if (this.#notices > noticesMax) {
        this.drop(new InternalError(`the server sends more than ${noticesMax} responses of unknown kinds, expected: an answer`));
      }
      return;
    }
    this.#notices = 0;
    const oldest = this.#unanswered[0];
    if (oldest === undefined || response.sequenceNumber !== oldest.request.sequenceNumber) {
      const expected = oldest === undefined ? "no answer" : oldest.request.sequenceNumber;
      this.drop(
        new InternalError(`${this.#attach.pool} answered request ${response.sequenceNumber}, expected: ${expected}`),
      );
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
        const kind = response.response.case ?? "an unknown kind";
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

  // Decodes a complete answer. An incomplete one is not decoded, because it is sent again after a
  // broken connection.
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

  // Resumes with a new connection, or ends the stream with the error.
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
        this.#checkNextNumber(await this.#openBy(deadline));
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
    // A timer, because a deadline of the call would apply to the whole stream.
    let isLate = false; // Not read from the clock, because a timer may fire a fraction of a millisecond early.
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

  // Checks that no other client has stepped the pool.
  #checkNextNumber(attached: Attached): void {
    const next = Number(attached.nextSequenceNumber);
    const least = Number(this.#unanswered[0]?.request.sequenceNumber ?? this.#nextSequenceNumber);
    if (next < least || next > this.#nextSequenceNumber) {
      throw new AbortedError(
        `${this.#attach.pool} is at request ${next}, and this stream left it between ${least} and ` +
          `${this.#nextSequenceNumber}: another client has stepped it, or it is another pool of the same name`,
      );
    }
  }
}

// Returns a request with its number. Throws InvalidArgumentError, before the stream is used: a
// value does not fit its field.
function numbered(body: RequestBody, sequenceNumber: number): StepPoolRequest {
  try {
    const request = create(StepPoolRequestSchema, { sequenceNumber: BigInt(sequenceNumber), request: body });
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
  // gRPC's statuses after a socket reset within a stream.
  return error.code === status.UNKNOWN || (error.code === status.INTERNAL && error.details.includes("RST_STREAM"));
}
