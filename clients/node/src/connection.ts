// A connection to a server: calls of the contract's methods, without their meaning.

import {
  create, fromBinary, toBinary,
  type DescMessage, type DescMethodServerStreaming, type DescMethodUnary, type MessageInitShape, type MessageShape,
} from "@bufbuild/protobuf";
import { Client as GrpcClient, type ChannelOptions, type ClientDuplexStream, type Metadata, type ServiceError } from "@grpc/grpc-js";
import { callMetadata, channelCredentials, isThisMachine, type Credentials } from "./credentials.js";
import { CancelledError, fromServiceError, InvalidArgumentError, UnavailableError } from "./errors.js";
import {
  StepPoolRequestSchema, StepPoolResponseSchema, StepService, type StepPoolRequest, type StepPoolResponse,
} from "./generated/procgen/v1/step_pb.js";
import { latestOf } from "./latest.js";
import { channelBackoffMaxMs, channelBackoffMinMs, keepaliveTimeMs, keepaliveTimeoutMs } from "./timing.js";

export type StepPoolCall = ClientDuplexStream<StepPoolRequest, StepPoolResponse>;

export interface CallOptions {
  // Gives the call up: it ends with CancelledError.
  signal?: AbortSignal;
  // How long it may take, in milliseconds.
  timeoutMs?: number;
}

export class Connection {
  readonly #client: GrpcClient;
  readonly #metadata: Metadata;
  readonly #patientMetadata: Metadata;
  #closed = false;

  constructor(
    readonly address: string,
    readonly callTimeoutMs: number,
    credentials: Credentials,
  ) {
    this.#client = new GrpcClient(address, channelCredentials(credentials, address), channelOptions(address));
    this.#metadata = callMetadata(credentials, false);
    this.#patientMetadata = callMetadata(credentials, true);
  }

  get closed(): boolean {
    return this.#closed;
  }

  close(): void {
    this.#closed = true;
    this.#client.close();
  }

  // Calls a method. `waitForReady`: a server that is just starting is waited for.
  async unary<I extends DescMessage, O extends DescMessage>(
    method: DescMethodUnary<I, O>,
    init: MessageInitShape<I>,
    { signal, timeoutMs = this.callTimeoutMs }: CallOptions = {},
    waitForReady = false,
  ): Promise<MessageShape<O>> {
    this.#requireOpen();
    throwIfAborted(signal);
    const request = encoded(method.input, init);
    return new Promise((resolve, reject) => {
      const abort = () => call.cancel();
      const call = this.#client.makeUnaryRequest(
        pathOf(method),
        (bytes: Uint8Array) => Buffer.from(bytes.buffer, bytes.byteOffset, bytes.length),
        (bytes: Buffer) => fromBinary(method.output, bytes),
        request,
        waitForReady ? this.#patientMetadata : this.#metadata,
        { deadline: Date.now() + timeoutMs },
        (error, response) => {
          signal?.removeEventListener("abort", abort);
          if (error) {
            reject(signal?.aborted ? aborted(signal) : fromServiceError(error));
          } else {
            resolve(response!);
          }
        },
      );
      signal?.addEventListener("abort", abort, { once: true });
    });
  }

  // Calls a method that tells again and again how something is: gives the latest each time. Ends with an error; who leaves
  // the loop over it ends the call.
  async *serverStream<I extends DescMessage, O extends DescMessage>(
    method: DescMethodServerStreaming<I, O>,
    init: MessageInitShape<I>,
    signal?: AbortSignal,
  ): AsyncGenerator<MessageShape<O>, void, void> {
    this.#requireOpen();
    throwIfAborted(signal);
    const call = this.#client.makeServerStreamRequest(
      pathOf(method),
      (bytes: Uint8Array) => Buffer.from(bytes.buffer, bytes.byteOffset, bytes.length),
      (bytes: Buffer) => fromBinary(method.output, bytes),
      encoded(method.input, init),
      this.#metadata,
    );
    const abort = () => call.cancel();
    signal?.addEventListener("abort", abort, { once: true });
    try {
      for await (const message of latestOf(call)) {
        throwIfAborted(signal);
        yield message;
      }
    } catch (error) {
      throw signal?.aborted ? aborted(signal) : fromServiceError(error as ServiceError);
    } finally {
      signal?.removeEventListener("abort", abort);
      call.cancel();
    }
    throw new UnavailableError(`the server at ${this.address} ended its answers`);
  }

  // Begins a call of StepPool.
  stepPool(waitForReady: boolean): StepPoolCall {
    this.#requireOpen();
    return this.#client.makeBidiStreamRequest(
      pathOf(StepService.method.stepPool),
      (request: StepPoolRequest) => Buffer.from(toBinary(StepPoolRequestSchema, request)),
      decodedResponse,
      waitForReady ? this.#patientMetadata : this.#metadata,
    );
  }

  #requireOpen(): void {
    if (this.#closed) {
      throw new CancelledError(`the connection to ${this.address} was closed by this client`);
    }
  }
}

// A message as bytes. A value that does not fit its field is an InvalidArgumentError.
export function encoded<S extends DescMessage>(schema: S, init: MessageInitShape<S>): Uint8Array {
  try {
    return toBinary(schema, create(schema, init));
  } catch (error) {
    throw new InvalidArgumentError(`${schema.name} has a wrong value: ${(error as Error).message}`, { cause: error });
  }
}

// Observations of the message are views of `bytes`.
function decodedResponse(bytes: Buffer): StepPoolResponse {
  // Plain arrays: the slices of a Buffer are views, those of a Uint8Array copies.
  const plain = new Uint8Array(bytes.buffer, bytes.byteOffset, bytes.length);
  return fromBinary(StepPoolResponseSchema, plain, { readUnknownFields: false });
}

export function throwIfAborted(signal?: AbortSignal): void {
  if (signal?.aborted) {
    throw aborted(signal);
  }
}

export function aborted(signal: AbortSignal): CancelledError {
  return new CancelledError("given up by its AbortSignal", { cause: signal.reason });
}

function pathOf(method: { parent: { typeName: string }; name: string }): string {
  return `/${method.parent.typeName}/${method.name}`;
}

function channelOptions(address: string): ChannelOptions {
  return {
    // Attach tells the server how large responses may be, and far less is usual. This is what one that does not care can
    // make this process take.
    "grpc.max_receive_message_length": 256 * 1024 * 1024,
    "grpc.max_send_message_length": -1,
    // A whole response is on its way at once, and not a window of 64 KiB after the other.
    "grpc-node.flow_control_window": 8 * 1024 * 1024,
    // A connection of its own for each client, so that several in one process do not share one.
    "grpc.use_local_subchannel_pool": 1,
    // A connection that is silent is asked for a sign of life, so that a dead one is found.
    "grpc.keepalive_time_ms": keepaliveTimeMs,
    "grpc.keepalive_timeout_ms": keepaliveTimeoutMs,
    // A server that is just starting is found soon.
    "grpc.initial_reconnect_backoff_ms": channelBackoffMinMs,
    "grpc.min_reconnect_backoff_ms": channelBackoffMinMs,
    "grpc.max_reconnect_backoff_ms": channelBackoffMaxMs,
    // This very machine is never behind a proxy, whatever http_proxy says.
    ...(isThisMachine(address) ? { "grpc.enable_http_proxy": 0 } : {}),
  };
}
