// Pools of pages, told by their names.

const PATTERN = /^pools\/web-(play|replay|gallery)-/;

// An unused id of a pool of a page. `kind`: "play", "replay" or "gallery".
export function newPoolId(kind) {
  const digits = [...crypto.getRandomValues(new Uint8Array(8))].map((byte) => byte.toString(16).padStart(2, "0"));
  return `web-${kind}-${digits.join("")}`;
}

// The kind of a pool by its name: that of a page's pool, or "pool".
export function kindOf(name) {
  return PATTERN.exec(name)?.[1] ?? "pool";
}
