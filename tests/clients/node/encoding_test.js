// Encoded observations decode to the raw ones, and damage is detected.

import assert from "node:assert/strict";
import { test } from "node:test";
import { create } from "../../../clients/node/node_modules/@bufbuild/protobuf/dist/esm/index.js";
import {
  Color, DataLossError, Encoding, FailedPreconditionError, InvalidArgumentError, Layout, ObservationDecoder, PoolSchema,
} from "../../../clients/node/dist/index.js";
import { actionsOf, easy, withServer } from "./server.js";

const it = withServer();
const formats = [
  undefined,
  { color: Color.GRAYSCALE, sizePx: 84, frameStack: 4 },
  { layout: Layout.CHW, sizePx: 21, frameStack: 2 },
];

for (const [number, observationFormat] of formats.entries()) {
  test(`encoded observations are lossless in format ${number}`, async () => {
    const spec = easy(["bigfish", "jumper", "maze"], 6, { observationFormat });
    const raw = await it.client.createPool(spec);
    const encoded = await it.client.createPool({ ...spec, encoding: Encoding.DELTA_ZSTD });
    for (let step = 0; step < 80; step += 1) {
      const [expected, batch] = await Promise.all([raw, encoded].map((pool) => pool.step(actionsOf(step, 6))));
      assert.equal(Buffer.compare(batch.observations, expected.observations), 0, `step ${step}`);
    }
    await encoded.detach();
    assert.deepEqual((await encoded.observe()).observations, Uint8Array.from((await raw.observe()).observations));
    await raw.close();
    await encoded.close();
  });
}

test("the removed encoding is rejected", async () => {
  await assert.rejects(it.client.createPool(easy(["maze"], 1, { encoding: 3 })), InvalidArgumentError);
});

// A zstd frame with one raw block.
function zstdFrame(content) {
  const frame = Buffer.alloc(6 + 3 + content.length);
  frame.writeUInt32LE(0xfd2fb528, 0);
  frame[4] = 0x20; // Single segment: the content size takes one byte. No checksum.
  frame[5] = content.length;
  frame.writeUIntLE(content.length * 8 + 1, 6, 3); // The last block, raw.
  frame.set(content, 9);
  return frame;
}

function decoder() {
  const observationFormat = { color: Color.GRAYSCALE, sizePx: 16 };
  const spec = { games: ["maze"], envCount: 1, observationFormat, encoding: Encoding.DELTA_ZSTD };
  return new ObservationDecoder(create(PoolSchema, { spec }));
}

// One environment of 2 x 2 blocks: age, changed, down, right, rows, masks, values.
const onePixel = [0, 0b0001, 0, 0, 0b10, 0b100, 77];

test("the tables match the proto", () => {
  const decoding = decoder();
  const shown = decoding.decode(0, 1, zstdFrame(onePixel));
  assert.equal(shown[16 + 2], 77);
  assert.equal(shown.reduce((sum, value) => sum + value), 77);
  // The block is shifted down by one row and right by two pixels.
  const moved = decoding.decode(0, 1, zstdFrame([1, 0b0001, 1, 2, 0]));
  assert.equal(moved[0], 77);
});

for (const [what, content] of Object.entries({
  "a table that ends": onePixel.slice(0, 5),
  "bytes too many": [...onePixel, 0],
  "a block beyond the picture": [0, 0b10000, 0, 0, 0],
  "a row without pixels": [0, 1, 0, 0, 1, 0],
})) {
  test(`${what} is detected`, () => assert.throws(() => decoder().decode(0, 1, zstdFrame(content)), DataLossError));
}

test("truncated frames and wrong sizes are detected", () => {
  const frame = zstdFrame(onePixel);
  assert.throws(() => decoder().decode(0, 1, frame.subarray(0, 8)), DataLossError);
  frame[5] = 255;
  assert.throws(() => decoder().decode(0, 1, frame), DataLossError);
  assert.throws(() => decoder().decode(0, 1, Buffer.from("no frame of any kind")), DataLossError);
});

test("a missing response is detected", () => {
  const decoding = decoder();
  decoding.decode(0, 1, zstdFrame(onePixel));
  assert.throws(() => decoding.decode(0, 1, zstdFrame([2, 0])), FailedPreconditionError);
  decoding.decode(0, 1, zstdFrame([1, 0]));
});
