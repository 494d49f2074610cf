// Formatting of numbers.

const whole = new Intl.NumberFormat("en", { maximumFractionDigits: 0 });
const digits = new Intl.NumberFormat("en", { maximumSignificantDigits: 3 });
const short = new Intl.NumberFormat("en", { notation: "compact", maximumSignificantDigits: 3 });

// Placeholder for a missing number.
export const NONE = "–";

function known(value) {
  return typeof value === "number" && Number.isFinite(value);
}

// 1234567 -> "1,234,567"
export function count(value) {
  return known(value) ? whole.format(value) : NONE;
}

// 1234567 -> "1.23M"
export function rate(value) {
  return known(value) ? short.format(value) : NONE;
}

// 7.25 -> "7.25", 10 -> "10"
export function reward(value) {
  return known(value) ? String(Math.round(value * 100) / 100) : NONE;
}

// 0.12345 -> "0.123"
export function significant(value) {
  return known(value) ? digits.format(value) : NONE;
}

// 0.00123 s -> "1.23 ms", given in milliseconds
export function milliseconds(value) {
  if (!known(value)) {
    return NONE;
  }
  if (value >= 1000) {
    return `${Number((value / 1000).toPrecision(3))} s`;
  }
  return value < 1 ? `${Math.round(value * 1000)} µs` : `${Number(value.toPrecision(3))} ms`;
}

// 1 environment, 2 environments
export function plural(number, noun) {
  return `${count(number)} ${noun}${number === 1 ? "" : "s"}`;
}

// 250 s -> "4 min"
export function duration(seconds) {
  if (!known(seconds)) {
    return NONE;
  }
  const { unit, length } = DURATION_UNITS.find((each) => seconds >= each.length) ?? { unit: "s", length: 1 };
  return `${Math.max(0, Math.floor(seconds / length))} ${unit}`;
}

const DURATION_UNITS = [{ unit: "d", length: 86400 }, { unit: "h", length: 3600 }, { unit: "min", length: 60 }];

// A time in seconds since 1970 -> "08:10:05", in local time
export function clock(seconds) {
  return new Date(seconds * 1000).toLocaleTimeString("en-GB");
}
