// Traces, passed between pages and saved as files. A trace is bytes; the tab keeps one, for the replay page.

import { saveFile } from "../export/files.js";

const KEY = "trace";

// Keeps a trace, replacing the previous one. `place`: of the episode that it contains (see links/replay_link.js), or null.
// Returns false if it is too large.
export function keepTrace({ bytes, name, place }) {
  const text = bytes.reduce((sum, byte) => sum + String.fromCharCode(byte), "");
  try {
    sessionStorage.setItem(KEY, JSON.stringify({ name, place, content: btoa(text) }));
  } catch (error) {
    if (error.name !== "QuotaExceededError") {
      throw error;
    }
    sessionStorage.removeItem(KEY);
    return false;
  }
  return true;
}

// Opens the replay page with a trace; a trace that is too large to pass is saved as a file.
export function replayTrace(bytes, name) {
  if (keepTrace({ bytes, name, place: null })) {
    location.assign("/replay");
  } else {
    saveTrace(bytes, name);
  }
}

// The kept trace, { bytes, name, place }, or null.
export function keptTrace() {
  const kept = JSON.parse(sessionStorage.getItem(KEY));
  return kept && { name: kept.name, place: kept.place ?? null, bytes: Uint8Array.from(atob(kept.content), (letter) => letter.charCodeAt(0)) };
}

// Downloads a trace as a file.
export function saveTrace(bytes, name) {
  saveFile(new Blob([bytes], { type: "application/octet-stream" }), name);
}
