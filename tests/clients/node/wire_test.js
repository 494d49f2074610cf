// Responses are read as the generated message reads them, however they are written.

import assert from "node:assert/strict";
import { test } from "node:test";
import { create, toBinary } from "../../../clients/node/node_modules/@bufbuild/protobuf/dist/esm/index.js";
import { BinaryWriter, WireType } from "../../../clients/node/node_modules/@bufbuild/protobuf/dist/esm/wire/index.js";
import { readResponse, StepPoolResponseSchema } from "../../../clients/node/dist/index.js";
import { BatchSchema } from "../../../clients/node/dist/generated/procgen/v1/step_pb.js";
import { partOf } from "../../../clients/node/dist/wire.js";

const batch = create(BatchSchema, {
  firstEnv: 3, envCount: 2, last: true,
  rewards: [0, 10.5], first: [true, false], terminated: [false, true], truncated: [false, false],
  levelSeeds: [-1, 2 ** 30], prevLevelSeeds: [4, 5], prevLevelComplete: [false, true], episodeReturns: [1, -2],
  episodeLengths: [8, 9], fingerprints: [-5n],
  finalObservations: Uint8Array.of(1, 2, 3), observations: Uint8Array.of(4, 5, 6, 7, 8, 9),
});

function responseWith(batchBytes) {
  return new BinaryWriter().tag(1, WireType.Varint).int64(7n).tag(4, WireType.LengthDelimited).bytes(batchBytes).finish();
}

test("pictures are views of what was received, and all values are the message's", () => {
  const message = toBinary(StepPoolResponseSchema, create(StepPoolResponseSchema, {
    sequenceNumber: 7n, response: { case: "batch", value: batch },
  }));
  const part = readResponse(Buffer.from(message.buffer));
  assert.deepEqual(part, partOf(7n, batch));
  assert.equal(part.arrays.observations.buffer, message.buffer);
  assert.equal(part.arrays.fingerprints[0], 2n ** 64n - 5n);
});

test("fields of a later server are ignored", () => {
  const later = new BinaryWriter().raw(toBinary(BatchSchema, batch)).tag(999, WireType.Varint).int32(1).finish();
  assert.deepEqual(readResponse(responseWith(later)), partOf(7n, batch));
});

test("arrays that are written otherwise are read, too", () => {
  const unpacked = new BinaryWriter().raw(toBinary(BatchSchema, batch)).tag(5, WireType.Bit32).float(2.5).finish();
  assert.deepEqual([...readResponse(responseWith(unpacked)).arrays.rewards], [0, 10.5, 2.5]);
  const twice = new BinaryWriter().raw(toBinary(BatchSchema, batch)).raw(toBinary(BatchSchema, create(BatchSchema, { levelSeeds: [6] })));
  assert.deepEqual([...readResponse(responseWith(twice.finish())).arrays.levelSeeds], [-1, 2 ** 30, 6]);
});

test("nonsense is an error", () => assert.throws(() => readResponse(Uint8Array.of(0xff, 0xff))));
