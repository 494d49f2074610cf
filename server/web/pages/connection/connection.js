// The WebSocket of a page: requests, answers and events. Reconnects automatically.

import { decode, encode } from "./wire.js";

export const LOST = "LOST";

const WAITS_MS = [250, 500, 1000, 2000, 4000];
const SILENCE_MS = 5000;

// An error answer of the server, or LOST if the connection broke.
export class ServerError extends Error {
  constructor({ code, message }) {
    super(message);
    this.name = "ServerError";
    this.code = code;
  }
}

// Dispatches "open" each time a socket opens, "lost" with its code and reason when it closes (the connection is then retried), and
// "message:EVENT" with the message as `detail` for each event of the server; "silent" with the time of the last message when the
// server sends nothing for SILENCE_MS although a message is due, and "heard" at the next message.
export class Connection extends EventTarget {
  expectsEvents = false;  // events are due every second, not only answers
  #socket = null;
  #timer = null;
  #attempts = 0;
  #lastId = 0;
  #waiting = new Map();  // request's id -> { resolve, reject }
  #heard = 0;            // when the last message was received, or the first one became due, by performance.now()
  #isSilent = false;

  constructor() {
    super();
    setInterval(() => this.#checkSilence(), 1000);
  }

  open() {
    clearTimeout(this.#timer);
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    const socket = new WebSocket(`${scheme}//${location.host}/socket`);
    socket.binaryType = "arraybuffer";
    socket.addEventListener("open", () => {
      this.#heard = performance.now();
      this.dispatchEvent(new Event("open"));
    });
    socket.addEventListener("message", ({ data }) => this.#receive(data));
    socket.addEventListener("close", ({ code, reason }) => this.#lose(socket, { code, reason }));
    this.#socket = socket;
  }

  // Closes the connection until the next `open`.
  close() {
    const socket = this.#socket;
    this.#socket = null;
    socket.close();
    this.#abandon();
  }

  // Sends a request, which is binary with `part`, the bytes of a trace. Resolves to the result, with the `parts` of a binary
  // answer; rejects with a ServerError.
  call(method, fields = {}, part = null) {
    if (this.#socket?.readyState !== WebSocket.OPEN) {
      return Promise.reject(new ServerError({ code: LOST, message: "Not connected to the server." }));
    }
    if (this.#waiting.size === 0 && !this.expectsEvents) {
      this.#heard = performance.now();
    }
    const id = ++this.#lastId;
    const request = { id, method, ...fields };
    this.#socket.send(part === null ? JSON.stringify(request)
      : encode({ ...request, parts: [{ name: "trace", format: "trace", bytes: part.length }] }, [part]));
    return new Promise((resolve, reject) => this.#waiting.set(id, { resolve, reject }));
  }

  // Calls `listener` with each event of this name.
  on(event, listener) {
    this.addEventListener(`message:${event}`, ({ detail }) => listener(detail));
  }

  #receive(data) {
    this.#attempts = 0;
    this.#heard = performance.now();
    if (this.#isSilent) {
      this.#isSilent = false;
      this.dispatchEvent(new Event("heard"));
    }
    const message = typeof data === "string" ? JSON.parse(data) : decode(data);
    if (message.event) {
      this.dispatchEvent(new CustomEvent(`message:${message.event}`, { detail: message }));
      return;
    }
    const waiting = this.#waiting.get(message.id);
    this.#waiting.delete(message.id);
    if (message.error) {
      waiting?.reject(new ServerError(message.error));
    } else {
      waiting?.resolve({ ...message.result, parts: message.parts });
    }
  }

  // A server that does not answer may still be connected.
  #checkSilence() {
    const silence = performance.now() - this.#heard;
    const isDue = this.#socket?.readyState === WebSocket.OPEN && (this.expectsEvents || this.#waiting.size > 0);
    if (isDue && silence > SILENCE_MS && !this.#isSilent) {
      this.#isSilent = true;
      this.dispatchEvent(new CustomEvent("silent", { detail: { time_s: (Date.now() - silence) / 1000 } }));
    }
  }

  #lose(socket, detail) {
    if (socket !== this.#socket) {
      return;
    }
    this.#abandon();
    const wait = WAITS_MS[Math.min(this.#attempts, WAITS_MS.length - 1)];
    this.#attempts += 1;
    this.#timer = setTimeout(() => this.open(), wait);
    this.dispatchEvent(new CustomEvent("lost", { detail }));
  }

  // Nothing is due any more: rejects the requests without an answer.
  #abandon() {
    this.#isSilent = false;
    this.expectsEvents = false;
    const lost = new ServerError({ code: LOST, message: "The connection to the server was lost." });
    this.#waiting.forEach(({ reject }) => reject(lost));
    this.#waiting.clear();
  }
}
