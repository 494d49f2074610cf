// Connection: untyped calls of the API's methods over one gRPC channel.

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
  // Cancels the call, which then throws CancelledError.
  signal?: AbortSignal;
  // Timeout in milliseconds.
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

  // Calls a unary method. `waitForReady`: wait for a server that is starting.
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

  // Calls a server-streaming method and yields the latest response each time. Always ends with an
  // error. Leaving the loop ends the call.
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
    throw new UnavailableError(`the server at ${this.address} ended the stream`);
  }

  // Starts a StepPool call.
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

// Serializes a message. Throws InvalidArgumentError: a value does not fit its field.
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
  return new CancelledError("cancelled by its AbortSignal", { cause: signal.reason });
}

function pathOf(method: { parent: { typeName: string }; name: string }): string {
  return `/${method.parent.typeName}/${method.name}`;
}

function channelOptions(address: string): ChannelOptions {
  return {
    // Attach.responseBytesMax bounds responses far below this. It only protects against a server
    // that ignores it.
    "grpc.max_receive_message_length": 256 * 1024 * 1024,
    "grpc.max_send_message_length": -1,
    // Room for a whole response; the default window is 64 KiB.
    "grpc-node.flow_control_window": 8 * 1024 * 1024,
    // One connection per client, not shared within the process.
    "grpc.use_local_subchannel_pool": 1,
    // Keepalive pings detect a dead connection.
    "grpc.keepalive_time_ms": keepaliveTimeMs,
    "grpc.keepalive_timeout_ms": keepaliveTimeoutMs,
    // Finds a server that is starting soon after it listens.
    "grpc.initial_reconnect_backoff_ms": channelBackoffMinMs,
    "grpc.min_reconnect_backoff_ms": channelBackoffMinMs,
    "grpc.max_reconnect_backoff_ms": channelBackoffMaxMs,
    // Ignores http_proxy for addresses of this machine.
    ...(isThisMachine(address) ? { "grpc.enable_http_proxy": 0 } : {}),
  };
}
