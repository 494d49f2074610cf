// Reads StepPool responses without copying observations. On the wire each array of a batch is the
// little-endian array (proto/README.md, "On the wire"). Observations are views of the received
// bytes; numeric arrays are copied once for alignment. Fields in another valid form (unpacked, or
// in several pieces) are read through the generated message.

import { fromBinary } from "@bufbuild/protobuf";
import { BinaryReader, WireType } from "@bufbuild/protobuf/wire";
import type { BatchArrays, Part } from "./batch.js";
import {
  BatchSchema,
  StepPoolResponseSchema,
  type Batch as BatchMessage,
  type StepPoolResponse,
} from "./generated/procgen/v1/step_pb.js";

export type Response = Part | StepPoolResponse;

export function isPart(response: Response): response is Part {
  return "arrays" in response;
}

// The response has another form than this reader expects.
class UnexpectedForm extends Error {}

const makers = {
  rewards: (bytes: ArrayBuffer) => new Float32Array(bytes),
  first: (bytes: ArrayBuffer) => new Uint8Array(bytes),
  terminated: (bytes: ArrayBuffer) => new Uint8Array(bytes),
  truncated: (bytes: ArrayBuffer) => new Uint8Array(bytes),
  levelSeeds: (bytes: ArrayBuffer) => new Int32Array(bytes),
  prevLevelSeeds: (bytes: ArrayBuffer) => new Int32Array(bytes),
  prevLevelComplete: (bytes: ArrayBuffer) => new Uint8Array(bytes),
  episodeReturns: (bytes: ArrayBuffer) => new Float32Array(bytes),
  episodeLengths: (bytes: ArrayBuffer) => new Int32Array(bytes),
  fingerprints: (bytes: ArrayBuffer) => new BigUint64Array(bytes),
};
type NumberArray = keyof typeof makers;

const flags = new Set(["first", "terminated", "truncated", "prevLevelComplete"]);
const arrayNames = new Map<number, keyof BatchArrays>(
  BatchSchema.fields
    .filter((field) => field.localName in makers || field.fieldKind === "scalar" && field.name.endsWith("observations"))
    .filter((field) => !field.name.startsWith("shared_"))
    .map((field) => [field.number, field.localName as keyof BatchArrays]),
);
const { sequenceNumber: sequenceField, batch: batchField } = StepPoolResponseSchema.field;
const { firstEnv: firstField, envCount: countField, last: lastField } = BatchSchema.field;

const empty = new Uint8Array(0);

// Parses a serialized StepPoolResponse: returns a Part if it contains a batch, else the message.
export function readResponse(received: Uint8Array): Response {
  // A Uint8Array, because slice() of a Buffer does not copy.
  const message = new Uint8Array(received.buffer, received.byteOffset, received.length);
  try {
    return readBatchResponse(message);
  } catch (error) {
    if (!(error instanceof UnexpectedForm || error instanceof RangeError)) {
      throw error;
    }
    const response = fromBinary(StepPoolResponseSchema, message);
    return response.response.case === "batch" ? partOf(response.sequenceNumber, response.response.value) : response;
  }
}

// Converts the generated message, with copies.
export function partOf(sequenceNumber: bigint, batch: BatchMessage): Part {
  const { firstEnv, envCount, last } = batch;
  const arrays: BatchArrays = {
    rewards: Float32Array.from(batch.rewards),
    first: Uint8Array.from(batch.first, Number),
    terminated: Uint8Array.from(batch.terminated, Number),
    truncated: Uint8Array.from(batch.truncated, Number),
    levelSeeds: Int32Array.from(batch.levelSeeds),
    prevLevelSeeds: Int32Array.from(batch.prevLevelSeeds),
    prevLevelComplete: Uint8Array.from(batch.prevLevelComplete, Number),
    episodeReturns: Float32Array.from(batch.episodeReturns),
    episodeLengths: Int32Array.from(batch.episodeLengths),
    fingerprints: BigUint64Array.from(batch.fingerprints, (hash) => BigInt.asUintN(64, hash)),
    finalObservations: batch.finalObservations,
    observations: batch.observations,
  };
  return { sequenceNumber: Number(sequenceNumber), firstEnv, envCount, last, arrays };
}

function readBatchResponse(message: Uint8Array): Part {
  const reader = new BinaryReader(message);
  let sequenceNumber = 0;
  let batch: Uint8Array | undefined;
  while (reader.pos < reader.len) {
    const [number, type] = reader.tag();
    if (number === sequenceField.number && type === WireType.Varint) {
      sequenceNumber = Number(reader.int64());
    } else if (number === batchField.number && type === WireType.LengthDelimited && batch === undefined) {
      batch = reader.bytes();
    } else {
      throw new UnexpectedForm();
    }
  }
  if (batch === undefined) {
    throw new UnexpectedForm();
  }
  return readBatch(batch, sequenceNumber);
}

function readBatch(batch: Uint8Array, sequenceNumber: number): Part {
  const reader = new BinaryReader(batch);
  const pieces = new Map<keyof BatchArrays, Uint8Array>();
  const part = { sequenceNumber, firstEnv: 0, envCount: 0, last: false };
  while (reader.pos < reader.len) {
    const [number, type] = reader.tag();
    const name = arrayNames.get(number);
    if (name !== undefined) {
      if (type !== WireType.LengthDelimited || pieces.has(name)) {
        throw new UnexpectedForm();
      }
      pieces.set(name, reader.bytes());
    } else if (number === firstField.number) {
      part.firstEnv = reader.int32();
    } else if (number === countField.number) {
      part.envCount = reader.int32();
    } else if (number === lastField.number) {
      part.last = reader.bool();
    } else {
      reader.skip(type, number); // An unknown field, which clients ignore.
    }
  }
  return { ...part, arrays: arraysOf(pieces) };
}

function arraysOf(pieces: ReadonlyMap<keyof BatchArrays, Uint8Array>): BatchArrays {
  const arrays: Record<string, unknown> = {
    observations: pieces.get("observations") ?? empty,
    finalObservations: pieces.get("finalObservations") ?? empty,
  };
  for (const name of Object.keys(makers) as NumberArray[]) {
    const bytes = (pieces.get(name) ?? empty).slice();
    if (flags.has(name) && bytes.some((flag) => flag > 1)) {
      throw new UnexpectedForm(); // A longer varint, or a value other than 0 and 1.
    }
    arrays[name] = makers[name](bytes.buffer as ArrayBuffer);
  }
  return arrays as unknown as BatchArrays;
}
