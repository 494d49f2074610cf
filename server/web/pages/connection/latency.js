// The latency of the connection, which requests sent ahead hide.

const PINGS = 3;
const EXECUTION_MS = 60;  // of a request on the server, and drawing its answer
const COUNT_MAX = 6;

// The number of requests in flight that sustain `perSecond` requests: 1 on a short line.
export async function requestsInFlight(connection, perSecond) {
  let least = Infinity;
  for (let i = 0; i < PINGS; i += 1) {
    const begin = performance.now();
    await connection.call("CatalogService.GetLoad");
    least = Math.min(least, performance.now() - begin);
  }
  return Math.min(COUNT_MAX, 1 + Math.floor((least + EXECUTION_MS) * perSecond / 1000));
}
