// The errors that this package throws. Those of a server come with its own message, which says what was given and
// what is allowed; what the client can tell by itself it throws as the same classes, without asking the server, so
// that a mistake does not cost the stream.

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

// A value is out of range, of a wrong length, or asks for what a game lacks: correct it.
export class InvalidArgumentError extends errorWith("INVALID_ARGUMENT") {}
// There is no such game or pool.
export class NotFoundError extends errorWith("NOT_FOUND") {}
// A pool of that name exists: choose another, or none.
export class AlreadyExistsError extends errorWith("ALREADY_EXISTS") {}
// The pool is in the wrong state: another stream is attached, an ended episode is stepped.
export class FailedPreconditionError extends errorWith("FAILED_PRECONDITION") {}
// Something else on this pool won: it was deleted, or another stream took over.
export class AbortedError extends errorWith("ABORTED") {}
// A limit of the server, which the message names.
export class ResourceExhaustedError extends errorWith("RESOURCE_EXHAUSTED") {}
// In the contract, but not offered by this server (see the catalog's `features`) or not by this client.
export class UnimplementedError extends errorWith("UNIMPLEMENTED") {}
// The server cannot be reached, starts or drains: repeat later, or elsewhere.
export class UnavailableError extends errorWith("UNAVAILABLE") {}
// The server took longer to answer than the client was told to wait.
export class DeadlineExceededError extends errorWith("DEADLINE_EXCEEDED") {}
// The call was given up by this client: an AbortSignal (its reason is the `cause`), or the client was closed.
export class CancelledError extends errorWith("CANCELLED") {}
// The server asks for credentials, and there were none or wrong ones.
export class UnauthenticatedError extends errorWith("UNAUTHENTICATED") {}
// The credentials do not allow this.
export class PermissionDeniedError extends errorWith("PERMISSION_DENIED") {}
// A snapshot or an encoded observation is damaged.
export class DataLossError extends errorWith("DATA_LOSS") {}
// A bug of the server, or an answer that this client cannot read.
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

// The error of this package for one of gRPC's.
export function fromServiceError(error: ServiceError): ProcgenError {
  const code = status[error.code] as Code;
  const known = classes[code];
  const message = error.details || error.message;
  return known ? new known(message) : new ProcgenError(message, code);
}
