// Compressed observations are those that would have come raw, and damaged ones are found.

import assert from "node:assert/strict";
import { test } from "node:test";
import { create } from "../../../clients/node/node_modules/@bufbuild/protobuf/dist/esm/index.js";
import {
  Color, DataLossError, Encoding, FailedPreconditionError, Layout, ObservationDecoder, PoolSchema,
} from "../../../clients/node/dist/index.js";
import { actionsOf, easy, withServer } from "./server.js";

const it = withServer();
const formats = [
  undefined,
  { color: Color.GRAYSCALE, widthPx: 84, frameStack: 4 },
  { layout: Layout.CHW, widthPx: 21, frameStack: 2 },
];

for (const encoding of [Encoding.ZSTD_DIFFERENCE, Encoding.LZ4_DIFFERENCE]) {
  for (const [number, observationFormat] of formats.entries()) {
    test(`${Encoding[encoding]} is lossless in format ${number}`, async () => {
      const spec = easy(["bigfish", "jumper", "maze"], 6, { observationFormat });
      const raw = await it.client.createPool(spec);
      const told = await it.client.createPool({ ...spec, encoding });
      for (let step = 0; step < 80; step += 1) {
        const [expected, batch] = await Promise.all([raw, told].map((pool) => pool.step(actionsOf(step, 6))));
        assert.equal(Buffer.compare(batch.observations, expected.observations), 0, `step ${step}`);
      }
      await told.detach();
      assert.deepEqual((await told.observe()).observations, Uint8Array.from((await raw.observe()).observations));
      await raw.close();
      await told.close();
    });
  }
}

// A frame that an encoder of LZ4 writes which compresses nothing.
function lz4Frame(content) {
  const frame = Buffer.alloc(15 + 4 + content.length + 4);
  frame.writeUInt32LE(0x184d2204, 0);
  frame[4] = 0x68; // Version 1, independent blocks, the size of the content; no checksum of it.
  frame[5] = 0x40;
  frame.writeBigUInt64LE(BigInt(content.length), 6);
  frame.writeUInt32LE(0x80000000 + content.length, 15);
  frame.set(content, 19);
  return frame;
}

function decoder() {
  const observationFormat = { color: Color.GRAYSCALE, widthPx: 16, heightPx: 16 };
  const spec = { games: ["maze"], envCount: 1, observationFormat, encoding: Encoding.LZ4_DIFFERENCE };
  return new ObservationDecoder(create(PoolSchema, { spec }));
}

// One environment of 2 x 2 blocks: age, changed, down, right, rows, masks, values.
const onePixel = [0, 0b0001, 0, 0, 0b10, 0b100, 77];

test("the tables are read as the contract has them", () => {
  const decoding = decoder();
  const shown = decoding.decode(0, 1, lz4Frame(onePixel));
  assert.equal(shown[16 + 2], 77);
  assert.equal(shown.reduce((sum, value) => sum + value), 77);
  // The block shows what is a row below and two pixels to the right.
  const moved = decoding.decode(0, 1, lz4Frame([1, 0b0001, 1, 2, 0]));
  assert.equal(moved[0], 77);
});

for (const [what, content] of Object.entries({
  "a table that ends": onePixel.slice(0, 5),
  "bytes too many": [...onePixel, 0],
  "a block beyond the picture": [0, 0b10000, 0, 0, 0],
  "a row without pixels": [0, 1, 0, 0, 1, 0],
})) {
  test(`${what} is found`, () => assert.throws(() => decoder().decode(0, 1, lz4Frame(content)), DataLossError));
}

test("frames that are cut off, or tell another size, are found", () => {
  const frame = lz4Frame(onePixel);
  assert.throws(() => decoder().decode(0, 1, frame.subarray(0, 12)), DataLossError);
  frame[6] = 255;
  assert.throws(() => decoder().decode(0, 1, frame), DataLossError);
  assert.throws(() => decoder().decode(0, 1, Buffer.from("no frame of any kind")), DataLossError);
});

test("an answer that is missing is found", () => {
  const decoding = decoder();
  decoding.decode(0, 1, lz4Frame(onePixel));
  assert.throws(() => decoding.decode(0, 1, lz4Frame([2, 0])), FailedPreconditionError);
  decoding.decode(0, 1, lz4Frame([1, 0]));
});
