// A TCP proxy that delays all bytes, as a long line does, and limits their rate, as a thin line does.

import { once } from "node:events";
import { createServer, connect } from "node:net";

export class SlowLine {
  #proxy;

  // Listens on loopback and forwards to `address`, a URL; each direction takes `delayMs` and at most `bytesPerSecond`.
  static async open(address, delayMs, bytesPerSecond = Infinity) {
    const line = new SlowLine();
    const { hostname, port } = new URL(address);
    line.#proxy = createServer((near) => {
      const far = connect(Number(port), hostname);
      for (const [from, to] of [[near, far], [far, near]]) {
        from.on("data", (bytes) => {
          setTimeout(() => to.writable && to.write(bytes), delayMs);
          from.pause();
          setTimeout(() => from.resume(), bytes.length * 1000 / bytesPerSecond);
        });
        from.on("close", () => setTimeout(() => to.destroy(), delayMs));
        from.on("error", () => to.destroy());
      }
    });
    line.#proxy.listen(0, "127.0.0.1");
    await once(line.#proxy, "listening");
    line.#proxy.unref();  // A test that fails before it closes the line must not keep the process alive.
    line.web = `http://127.0.0.1:${line.#proxy.address().port}`;
    return line;
  }

  close() {
    this.#proxy.close();
  }
}
