// Times and durations of messages, in seconds.

// The seconds of a Timestamp (since 1970) or Duration; null if it is absent.
export function secondsOf(time) {
  return time ? Number(time.seconds) + time.nanos / 1e9 : null;
}

export function millisecondsOf(duration) {
  return duration ? secondsOf(duration) * 1000 : null;
}
