// Batch: the values of environments after a request, as typed arrays.

import type { Batch as BatchMessage } from "./generated/procgen/v1/step_pb.js";

// The arrays of a batch of n environments, of which m have ended an episode in this step. F: the bytes of an observation.
export interface BatchArrays {
  // Reward of this step; where an episode ended, that of the old one         [n]
  rewards: Float32Array;
  // A new episode has started; 0 or 1, as all flags                          [n]
  first: Uint8Array;
  // The game (or action -1) ended the episode                                [n]
  terminated: Uint8Array;
  // The time limit ended the episode                                         [n]
  truncated: Uint8Array;
  // Seed of the level in the observation                                     [n]
  levelSeeds: Int32Array;
  // Seed of the level that was stepped                                       [n]
  prevLevelSeeds: Int32Array;
  // This step completed that level                                           [n]
  prevLevelComplete: Uint8Array;
  // Sum of the rewards of the ended or current episode                       [n]
  episodeReturns: Float32Array;
  // Steps of the same episode                                                [n]
  episodeLengths: Int32Array;
  // Hashes of the ended episodes, in order                                   [m]
  fingerprints: BigUint64Array;
  // Last observations of the ended episodes; empty unless requested          [m * F]
  finalObservations: Uint8Array;
  // Observations; empty with `observe: false`                                [n * F]
  observations: Uint8Array;
}

// One response with values: the answer to a request, or a part of it.
export interface Part {
  sequenceNumber: number;
  firstEnv: number;
  envCount: number;
  last: boolean;
  arrays: BatchArrays;
}

// The part that a response holds. Copies the number arrays; observations stay views of the received message.
export function partOf(sequenceNumber: bigint, batch: BatchMessage): Part {
  const { firstEnv, envCount, last } = batch;
  const arrays: BatchArrays = {
    rewards: copied(batch.rewards, Float32Array),
    first: copiedFlags(batch.first),
    terminated: copiedFlags(batch.terminated),
    truncated: copiedFlags(batch.truncated),
    levelSeeds: copied(batch.levelSeeds, Int32Array),
    prevLevelSeeds: copied(batch.prevLevelSeeds, Int32Array),
    prevLevelComplete: copiedFlags(batch.prevLevelComplete),
    episodeReturns: copied(batch.episodeReturns, Float32Array),
    episodeLengths: copied(batch.episodeLengths, Int32Array),
    fingerprints: BigUint64Array.from(batch.fingerprints, (hash) => BigInt.asUintN(64, hash)),
    finalObservations: batch.finalObservations,
    observations: batch.observations,
  };
  return { sequenceNumber: Number(sequenceNumber), firstEnv, envCount, last, arrays };
}

// A loop: TypedArray.from takes ten times as long.
function copied<T extends Float32Array | Int32Array>(values: readonly number[], ArrayType: new (length: number) => T): T {
  const copy = new ArrayType(values.length);
  for (let i = 0; i < values.length; i += 1) {
    copy[i] = values[i]!;
  }
  return copy;
}

function copiedFlags(values: readonly boolean[]): Uint8Array {
  const copy = new Uint8Array(values.length);
  for (let i = 0; i < values.length; i += 1) {
    copy[i] = values[i] ? 1 : 0;
  }
  return copy;
}

// How n environments stand after a request. Row i is environment firstEnv + i of the pool. `observations` and
// `finalObservations` are views of the received message, which nobody writes again; an answer of several responses is
// joined, and what came encoded is decoded, into arrays of their own.
export interface Batch extends BatchArrays {
  // Number of the request that this answers.
  sequenceNumber: number;
  // Index in the pool of row 0.
  firstEnv: number;
  // Number of rows, n.
  envCount: number;
  // Shape of one observation, e.g. [64, 64, 3].
  observationShape: readonly number[];
}

// Returns the observation of a row, as a view.
export function observationOf(batch: Batch, row: number): Uint8Array {
  const bytes = batch.observations.length / batch.envCount;
  return batch.observations.subarray(row * bytes, (row + 1) * bytes);
}

// Joins the validated responses to one request.
export function assemble(parts: readonly Part[], observationShape: readonly number[]): Batch {
  const head = parts[0]!;
  return {
    sequenceNumber: head.sequenceNumber,
    firstEnv: head.firstEnv,
    envCount: parts.reduce((sum, part) => sum + part.envCount, 0),
    observationShape,
    ...(parts.length === 1 ? head.arrays : joined(parts)),
  };
}

function joined(parts: readonly Part[]): BatchArrays {
  const arrays: Record<string, unknown> = {};
  for (const name of Object.keys(parts[0]!.arrays) as (keyof BatchArrays)[]) {
    const pieces = parts.map((part) => part.arrays[name]);
    const length = pieces.reduce((sum, piece) => sum + piece.length, 0);
    const whole = new (pieces[0]!.constructor as Uint8ArrayConstructor)(length);
    let at = 0;
    for (const piece of pieces) {
      whole.set(piece as Uint8Array, at);
      at += piece.length;
    }
    arrays[name] = whole;
  }
  return arrays as unknown as BatchArrays;
}
