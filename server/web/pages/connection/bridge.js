// The WebSocket of a page, which carries calls of the API. Reconnects automatically.

import { lostError } from "./errors.js";

const WAITS_MS = [250, 500, 1000, 2000, 4000];
const SILENCE_MS = 5000;
const REQUEST = "procgen.web.v1.BridgeRequest";
const RESPONSE = "procgen.web.v1.BridgeResponse";

// Dispatches "open" each time a socket opens, "lost" with its code and reason when it closes (the connection is then retried),
// "silent" with the time of the last message when the server sends nothing for SILENCE_MS although an answer is due, and "heard" at
// the next message.
export class Bridge extends EventTarget {
  #api;
  #socket = null;
  #timer = null;
  #attempts = 0;
  #lastNumber = 0;
  #calls = new Map();  // number -> { onMessage, onEnd, due: number of expected answers }
  #heard = 0;          // when the last message was received, or the first one became due, by performance.now()
  #isSilent = false;

  // `api`: an Api.
  constructor(api) {
    super();
    this.#api = api;
    setInterval(() => this.#checkSilence(), 1000);
  }

  // Calls `listener` with the detail of each event of this name.
  on(name, listener) {
    this.addEventListener(name, (event) => listener(/** @type {CustomEvent} */ (event).detail));
  }

  get isOpen() {
    return this.#socket?.readyState === WebSocket.OPEN;
  }

  open() {
    clearTimeout(this.#timer);
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    const socket = new WebSocket(`${scheme}//${location.host}/bridge`);
    socket.binaryType = "arraybuffer";
    socket.addEventListener("open", () => {
      this.#heard = performance.now();
      this.dispatchEvent(new Event("open"));
    });
    socket.addEventListener("message", ({ data }) => this.#receive(new Uint8Array(data)));
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

  // Sets the token of all calls opened from now on.
  sendToken(token) {
    this.#send(0, "token", token);
  }

  // Opens a call of the method at `path`. `onMessage(bytes)` is called with each response, `onEnd(status)` once at the end, with
  // null if the connection was lost. Returns { send(bytes, isAnswered), halfClose(), cancel() }; an answered message expects a
  // response.
  call(path, onMessage, onEnd) {
    if (!this.isOpen) {
      throw lostError();
    }
    this.#lastNumber += 1;
    const number = this.#lastNumber;
    const call = { onMessage, onEnd, due: 0 };
    this.#calls.set(number, call);
    this.#send(number, "method", path);
    const sendIfOpen = (kind, value) => this.#calls.get(number) === call && this.#send(number, kind, value);
    return {
      send: (bytes, isAnswered) => {
        this.#expect(call, isAnswered);
        sendIfOpen("message", bytes);
      },
      halfClose: () => sendIfOpen("halfClose", true),
      cancel: () => {
        call.due = 0;
        call.onMessage = () => {};
        call.onEnd = () => {};
        sendIfOpen("cancel", true);
      },
    };
  }

  #send(call, kind, value) {
    this.#socket.send(this.#api.encode(REQUEST, { call, request: { case: kind, value } }));
  }

  #expect(call, isAnswered) {
    if (isAnswered) {
      if (!this.#isDue()) {
        this.#heard = performance.now();
      }
      call.due += 1;
    }
  }

  #isDue() {
    return [...this.#calls.values()].some(({ due }) => due > 0);
  }

  #receive(bytes) {
    this.#attempts = 0;
    this.#heard = performance.now();
    if (this.#isSilent) {
      this.#isSilent = false;
      this.dispatchEvent(new Event("heard"));
    }
    const { call: number, response } = this.#api.decode(RESPONSE, bytes);
    const call = this.#calls.get(number);
    if (response.case === "end") {
      this.#calls.delete(number);
      call?.onEnd(response.value);
    } else if (call) {
      call.due = Math.max(0, call.due - 1);
      call.onMessage(response.value);
    }
  }

  // A server that does not answer may still be connected.
  #checkSilence() {
    const silence = performance.now() - this.#heard;
    if (this.isOpen && silence > SILENCE_MS && !this.#isSilent && this.#isDue()) {
      this.#isSilent = true;
      this.dispatchEvent(new CustomEvent("silent", { detail: { timeS: (Date.now() - silence) / 1000 } }));
    }
  }

  #lose(socket, detail) {
    if (socket !== this.#socket) {
      return;
    }
    this.#socket = null;
    this.#abandon();
    const wait = WAITS_MS[Math.min(this.#attempts, WAITS_MS.length - 1)];
    this.#attempts += 1;
    this.#timer = setTimeout(() => this.open(), wait);
    this.dispatchEvent(new CustomEvent("lost", { detail }));
  }

  // Nothing is due any more: ends all calls.
  #abandon() {
    this.#isSilent = false;
    const calls = [...this.#calls.values()];
    this.#calls.clear();
    calls.forEach(({ onEnd }) => onEnd(null));
  }
}
