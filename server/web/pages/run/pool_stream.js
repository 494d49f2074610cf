// A stream of RunPool.

import { DeltaDecoder } from "../connection/delta.js";
import { errorOf, lostError } from "../connection/errors.js";
import { newPoolId } from "./kinds.js";

const OK = 0;

export class PoolStream {
  #stream;
  #waiting = [];      // { resolve, reject } of requests without a response, oldest first
  #error = null;      // after the end
  #decoder = new DeltaDecoder();
  spec = null;        // PoolSpec, with every default

  // Starts a pool. `kind`: see kinds.js. Rejects with a UserError.
  static async start(connection, kind, spec) {
    const stream = new PoolStream(connection);
    const { pool } = await stream.request("start", { poolId: newPoolId(kind), spec });
    stream.spec = pool.spec;
    return stream;
  }

  constructor(connection) {
    this.#stream = connection.open("PoolService.RunPool", (message) => this.#receive(message),
      (error) => this.#end(error ?? errorOf({ code: OK, message: "The pool was closed." })));
  }

  // Sends a request, a field of RunPoolRequest. Requests may be sent ahead. Resolves to `convert(response)`: batches have `images`, the
  // observations by row. Callers need not wait for each response: an error rejects all later ones, too.
  request(field, value, convert = (response) => response) {
    if (this.#error) {
      const rejected = Promise.reject(this.#error);
      rejected.catch(() => {});
      return rejected;
    }
    const response = new Promise((resolve, reject) => { this.#waiting.push({ resolve, reject }); }).then(convert);
    response.catch(() => {});
    this.#stream.send({ request: { case: field, value } });
    return response;
  }

  // Ends the pool.
  close() {
    this.#stream.cancel();
    this.#end(lostError());
  }

  #receive({ response: { case: kind, value } }) {
    if (kind === "batch" && value.observations.length > 0) {
      const environments = Array.from({ length: value.envCount }, (_, i) => value.firstEnv + i);
      value.images = this.#decoder.decode(value.observations, environments);
    }
    this.#waiting.shift()?.resolve(value);
  }

  #end(error) {
    this.#error ??= error;
    this.#waiting.splice(0).forEach(({ reject }) => reject(error));
  }
}
