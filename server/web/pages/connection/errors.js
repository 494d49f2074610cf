// Errors whose messages are for the user.

// The code of calls that the lost connection ended.
export const LOST = "LOST";

// Canonical codes of gRPC, by number.
const CODES = [
  "OK", "CANCELLED", "UNKNOWN", "INVALID_ARGUMENT", "DEADLINE_EXCEEDED", "NOT_FOUND", "ALREADY_EXISTS", "PERMISSION_DENIED",
  "RESOURCE_EXHAUSTED", "FAILED_PRECONDITION", "ABORTED", "OUT_OF_RANGE", "UNIMPLEMENTED", "INTERNAL", "UNAVAILABLE", "DATA_LOSS",
  "UNAUTHENTICATED",
];

// An error that a page shows as a notice. `code`: the name of a canonical code, or LOST.
export class UserError extends Error {
  constructor(code, message) {
    super(message);
    this.name = "UserError";
    this.code = code;
  }
}

// The error of a Status of the bridge.
export function errorOf({ code, message }) {
  return new UserError(CODES[code] ?? "UNKNOWN", message || (CODES[code] ?? `code ${code}`).toLowerCase().replaceAll("_", " "));
}

export function lostError() {
  return new UserError(LOST, "The connection to the server was lost.");
}
