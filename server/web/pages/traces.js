// Traces, passed between pages and saved as files. A trace is bytes; the tab keeps one, for the replay page.

const KEY = "trace";

// Keeps a trace, replacing the previous one. Returns false if it is too large.
export function keepTrace(bytes, name) {
  const text = bytes.reduce((sum, byte) => sum + String.fromCharCode(byte), "");
  try {
    sessionStorage.setItem(KEY, JSON.stringify({ name, content: btoa(text) }));
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
  if (keepTrace(bytes, name)) {
    location.assign("/replay");
  } else {
    saveTrace(bytes, name);
  }
}

// The kept trace, { bytes, name }, or null.
export function keptTrace() {
  const kept = JSON.parse(sessionStorage.getItem(KEY));
  return kept && { name: kept.name, bytes: Uint8Array.from(atob(kept.content), (letter) => letter.charCodeAt(0)) };
}

// Downloads a trace as a file.
export function saveTrace(bytes, name) {
  const address = URL.createObjectURL(new Blob([bytes], { type: "application/octet-stream" }));
  const link = document.createElement("a");
  link.href = address;
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(address), 60_000);
}
