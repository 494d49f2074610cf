// Calls of the API by name, with typed messages.

import { Api } from "./api.js";
import { Bridge } from "./bridge.js";
import { errorOf, lostError } from "./errors.js";

export class Connection {
  #api;
  #bridge;

  static async load() {
    return new Connection(await Api.load());
  }

  // `api`: an Api.
  constructor(api) {
    this.#api = api;
    this.#bridge = new Bridge(api);
  }

  // The Bridge: it opens, closes and reconnects, and dispatches events of the connection.
  get bridge() {
    return this.#bridge;
  }

  // Calls a method with one request and one response, such as "PoolService.GetPool". Rejects with a UserError.
  call(name, request = {}) {
    return new Promise((resolve, reject) => {
      let response = null;
      const stream = this.open(name, (message) => { response = message; }, (error) => {
        if (error) {
          reject(error);
        } else {
          resolve(response);
        }
      });
      stream.send(request);
      stream.halfClose();
    });
  }

  // Calls a method with a stream of responses. `onEnd(error)` is called at the end, with null if it ended with OK. Returns
  // { cancel() }.
  watch(name, request, onMessage, onEnd) {
    const call = this.open(name, onMessage, onEnd);
    call.send(request, false);
    call.halfClose();
    return call;
  }

  // Opens a method with a stream of requests. Returns { send(request, isAnswered), halfClose(), cancel() }; an answered request expects
  // a response. Throws a UserError without a connection.
  open(name, onMessage, onEnd) {
    const method = this.#api.method(name);
    const call = this.#bridge.call(method.path, (bytes) => onMessage(method.decode(bytes)), (status) => onEnd(endOf(status)));
    return { ...call, send: (request, isAnswered = true) => call.send(method.encode(request), isAnswered) };
  }
}

// The error of a call that ended with a Status, or null.
function endOf(status) {
  return status === null ? lostError() : status.code === 0 ? null : errorOf(status);
}
