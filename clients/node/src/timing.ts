// All time limits and retry backoffs of this client, in milliseconds.

export const connectTimeoutDefaultMs = 10_000;
export const callTimeoutDefaultMs = 60_000;
export const reconnectTimeoutDefaultMs = 60_000;
// Timeout of the call that gets the reason for a failed connection.
export const reasonTimeoutMs = 1000;

// Idle time after which the client sends a keepalive ping, and time that the server has to answer
// it.
export const keepaliveTimeMs = 20_000;
export const keepaliveTimeoutMs = 10_000;

// Backoff between attempts to resume a stream: doubles each time, with a random factor in [0.5,
// 1.5).
export const backoffMinMs = 20;
export const backoffMaxMs = 2000;

// Backoff between gRPC's attempts to connect.
export const channelBackoffMinMs = 20;
export const channelBackoffMaxMs = 1000;

// Time that a ServerProcess has until it listens, and until it has stopped.
export const startTimeoutDefaultMs = 30_000;
export const stopTimeoutDefaultMs = 15_000;
