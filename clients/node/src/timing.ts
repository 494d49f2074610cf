// How long this client waits, in milliseconds: all its time limits and retry backoff.

export const connectTimeoutDefaultMs = 10_000;
export const callTimeoutDefaultMs = 60_000;
export const reconnectTimeoutDefaultMs = 60_000;
// Of the call that asks why a server cannot be reached.
export const reasonTimeoutMs = 1000;

// Idle time after which a ping is sent, and the time in which it must be answered.
export const keepaliveTimeMs = 20_000;
export const keepaliveTimeoutMs = 10_000;

// Between tries to resume a stream: doubled from try to try, times a random factor in [0.5, 1.5).
export const backoffMinMs = 20;
export const backoffMaxMs = 2000;

// Between gRPC's tries to connect.
export const channelBackoffMinMs = 20;
export const channelBackoffMaxMs = 1000;

// Of a ServerProcess: until it listens, and until it has stopped.
export const startTimeoutDefaultMs = 30_000;
export const stopTimeoutDefaultMs = 15_000;
