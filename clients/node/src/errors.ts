// The errors that this package throws. Errors of a server keep its message, which contains the
// value given and the values allowed. The client validates requests before sending and throws the
// same classes, because an error of the server would end the stream.

import { status, type ServiceError } from "@grpc/grpc-js";

// gRPC's status codes by name, e.g. "NOT_FOUND".
export type Code = keyof typeof status;

export class ProcgenError extends Error {
  constructor(
    message: string,
    readonly code: Code = "UNKNOWN",
    options?: ErrorOptions,
  ) {
    super(message, options);
    this.name = new.target.name;
  }
}

function errorWith(code: Code) {
  return class extends ProcgenError {
    constructor(message: string, options?: ErrorOptions) {
      super(message, code, options);
    }
  };
}

// A value is out of range, has a wrong length, or asks for a mode that a game does not have.
export class InvalidArgumentError extends errorWith("INVALID_ARGUMENT") {}
// No such game or pool.
export class NotFoundError extends errorWith("NOT_FOUND") {}
// The pool name is taken: choose another, or none.
export class AlreadyExistsError extends errorWith("ALREADY_EXISTS") {}
// The pool is in the wrong state: another stream is attached, an ended episode is stepped.
export class FailedPreconditionError extends errorWith("FAILED_PRECONDITION") {}
// Another call on this pool won: it was deleted, or another stream took over.
export class AbortedError extends errorWith("ABORTED") {}
// A limit of the server, named by the message.
export class ResourceExhaustedError extends errorWith("RESOURCE_EXHAUSTED") {}
// Not offered by this server (see the catalog's `features`) or by this client.
export class UnimplementedError extends errorWith("UNIMPLEMENTED") {}
// The server cannot be reached, starts or drains: retry later, or on another server.
export class UnavailableError extends errorWith("UNAVAILABLE") {}
// The server did not answer within the timeout.
export class DeadlineExceededError extends errorWith("DEADLINE_EXCEEDED") {}
// This client cancelled the call: by an AbortSignal (its reason is the `cause`), or because it was
// closed.
export class CancelledError extends errorWith("CANCELLED") {}
// Credentials are missing or unknown.
export class UnauthenticatedError extends errorWith("UNAUTHENTICATED") {}
// The server does not allow this.
export class PermissionDeniedError extends errorWith("PERMISSION_DENIED") {}
// A snapshot or an encoded observation is damaged.
export class DataLossError extends errorWith("DATA_LOSS") {}
// A bug in the server, or a response that does not match its request.
export class InternalError extends errorWith("INTERNAL") {}

const classes: Partial<Record<Code, new (message: string, options?: ErrorOptions) => ProcgenError>> = {
  INVALID_ARGUMENT: InvalidArgumentError,
  NOT_FOUND: NotFoundError,
  ALREADY_EXISTS: AlreadyExistsError,
  FAILED_PRECONDITION: FailedPreconditionError,
  ABORTED: AbortedError,
  RESOURCE_EXHAUSTED: ResourceExhaustedError,
  UNIMPLEMENTED: UnimplementedError,
  UNAVAILABLE: UnavailableError,
  DEADLINE_EXCEEDED: DeadlineExceededError,
  CANCELLED: CancelledError,
  UNAUTHENTICATED: UnauthenticatedError,
  PERMISSION_DENIED: PermissionDeniedError,
  DATA_LOSS: DataLossError,
  INTERNAL: InternalError,
};

// Converts an error of gRPC to one of this package.
export function fromServiceError(error: ServiceError): ProcgenError {
  const code = status[error.code] as Code;
  const known = classes[code];
  const message = error.details || error.message;
  return known ? new known(message) : new ProcgenError(message, code);
}
