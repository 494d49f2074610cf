// A learner of the Node client; hostile_test.py describes its output.

import { connect, DistributionMode, Encoding, EpisodeSelector, ProcgenError } from "../../../clients/node/dist/index.js";

const envCount = 5;
const table = Uint32Array.from({ length: 256 }, (_, value) => {
  for (let bit = 0; bit < 8; bit += 1) {
    value = value & 1 ? (value >>> 1) ^ 0xedb88320 : value >>> 1;
  }
  return value;
});

function crc32(before, array) {
  const bytes = new Uint8Array(array.buffer, array.byteOffset, array.byteLength);
  let crc = ~before;
  for (const byte of bytes) {
    crc = table[(crc ^ byte) & 0xff] ^ (crc >>> 8);
  }
  return ~crc >>> 0;
}

function digestOf(before, { observations, rewards, fingerprints, finalObservations }) {
  return [observations, rewards, fingerprints, finalObservations].reduce(crc32, before);
}

async function learn(address, encoding) {
  const client = await connect(address, { timeoutMs: 5000, callTimeoutMs: 5000, reconnectTimeoutMs: 1000 });
  try {
    const pool = await client.createPool({
      games: ["coinrun"],
      envCount,
      options: { distributionMode: DistributionMode.EASY, randSeed: 5n },
      encoding: encoding !== "raw" ? Encoding.DELTA_ZSTD : Encoding.RAW,
    });
    let digest = digestOf(0, await pool.observe());
    for (let step = 0; step < 10; step += 1) {
      const actions = Array.from({ length: envCount }, (_, i) => ((step * 31 + i * 17) % 16) - 1);
      digest = digestOf(digest, await pool.step(actions, { finalObservations: true }));
    }
    await pool.detach();
    for (const snapshot of await pool.saveStates([2, 0])) {
      digest = crc32(digest, Uint32Array.of(snapshot.length));
    }
    for (const { image } of await pool.render([1, 3], 64)) {
      digest = crc32(digest, image);
    }
    await pool.getEpisode(0, EpisodeSelector.CURRENT);
    for await (const listed of client.listPools()) {
      void listed;
    }
    await pool.close();
    return digest;
  } finally {
    client.close();
  }
}

for (const argument of process.argv.slice(2)) {
  const [mode, encoding, address] = argument.split("=");
  console.log(`begin ${mode}`);
  let report;
  try {
    report = { digest: await learn(address, encoding) };
  } catch (error) {
    if (!(error instanceof ProcgenError)) {
      throw error;
    }
    report = { error: error.constructor.name, message: error.message };
  }
  console.log(JSON.stringify({ mode, ...report }));
}
