// Validates responses before they are used, because a server may be faulty, malicious or of another
// version. All functions throw InternalError; the message contains the value given and the value
// expected.

import type { Part } from "./batch.js";
import { InternalError } from "./errors.js";
import { Encoding, type Pool } from "./generated/procgen/v1/pools_pb.js";
import type { Frame } from "./generated/procgen/v1/render_pb.js";
import type { SaveStatesResponse } from "./generated/procgen/v1/states_pb.js";
import { Observation, type Attach, type Attached, type StepPoolRequest } from "./generated/procgen/v1/step_pb.js";

// Bounds of the API: PoolSpec.total_env_count, the largest observation that ObservationFormat
// allows, and State.snapshot.
const envCountMax = 16777216;
const observationBytesMax = 16 * 512 * 512 * 3;
const snapshotBytesMax = 1 << 20;
const responseBytesDefault = 4194304;
// A page has 1000 pools; a list with more pages is treated as endless.
export const poolPagesMax = 1000;

const rowArrays = [
  "rewards", "first", "terminated", "truncated", "levelSeeds", "prevLevelSeeds", "prevLevelComplete", "episodeReturns",
  "episodeLengths",
] as const;

function wrong(given: string, expected: unknown): InternalError {
  return new InternalError(`the server's answer: ${given}, expected: ${expected}`);
}

// A consistent pool of this name with `envCount` environments (undefined: any).
export function checkPool(pool: Pool | undefined, name?: string, envCount?: number): asserts pool is Pool {
  if (pool === undefined || pool.name === "" || (name !== undefined && pool.name !== name)) {
    throw wrong(`pool ${JSON.stringify(pool?.name)}`, JSON.stringify(name));
  }
  const count = pool.spec?.envCount ?? 0;
  if (count < 1 || count > envCountMax || (envCount !== undefined && count !== envCount)) {
    throw wrong(`a pool of ${count} environments`, envCount ?? `1 to ${envCountMax}`);
  }
  const bytes = pool.observationShape.reduce((product, side) => product * Math.max(side, 0), 1);
  if (bytes < 1 || bytes > observationBytesMax || pool.observationShape.length === 0 || pool.observationBytes !== bytes) {
    throw wrong(`observations of ${pool.observationBytes} bytes`, `the product of ${JSON.stringify(pool.observationShape)}`);
  }
}

// A response to attach, for the pool `known`.
export function checkAttached(attached: Attached, attach: Attach, known: Pool): void {
  const { pool } = attached;
  checkPool(pool, known.name, known.spec!.envCount);
  if (
    JSON.stringify(pool.observationShape) !== JSON.stringify(known.observationShape) ||
    pool.spec!.encoding !== known.spec!.encoding
  ) {
    throw wrong(`${pool.name} of another shape or encoding`, "those it had before");
  }
  const bytesMax = Number(attach.responseBytesMax) || responseBytesDefault;
  if (attached.requestsInFlightMax < 1 || attached.responseBytesMax < 1 || attached.responseBytesMax > bytesMax) {
    throw wrong(
      `${attached.requestsInFlightMax} requests in flight and responses of ${attached.responseBytesMax} bytes`,
      `at least 1, and 1 to ${bytesMax}`,
    );
  }
  if (attached.sharedMemory !== undefined) {
    throw wrong(`shared memory ${attached.sharedMemory.path}`, "none");
  }
  if (attached.nextSequenceNumber < 1 || attached.nextSequenceNumber > Number.MAX_SAFE_INTEGER) {
    throw wrong(`next request ${attached.nextSequenceNumber}`, "1 or more");
  }
}

// The next response to a request, after the parts `before`.
export function checkPart(part: Part, request: StepPoolRequest, before: readonly Part[], attached: Attached): void {
  const body = request.request;
  if (body.case !== "step" && body.case !== "reset" && body.case !== "observe") {
    throw wrong(`values for request ${part.sequenceNumber}`, "an ack");
  }
  const { slice, observation } = body.value;
  const begin = slice?.firstEnv ?? 0;
  const next = before.reduce((sum, each) => sum + each.envCount, begin);
  const left = begin + (slice?.envCount || attached.pool!.spec!.envCount - begin) - next;
  const { sequenceNumber: number, envCount: count, arrays } = part;
  if (part.firstEnv !== next || count < 1 || count > left) {
    throw wrong(`request ${number}: ${count} environments from ${part.firstEnv}`, `1 to ${left} from ${next}`);
  }
  if (part.last !== (count === left)) {
    throw wrong(
      `request ${number}: ${part.last ? "the last" : "not the last"} response at environment ${next + count - 1}`,
      `the last at ${next + left - 1}`,
    );
  }
  const check = (name: keyof Part["arrays"], ...sizes: number[]) => {
    if (!sizes.includes(arrays[name].length)) {
      throw wrong(`request ${number}: ${name} of size ${arrays[name].length}`, sizes[0]);
    }
  };
  for (const name of rowArrays) {
    check(name, count);
  }
  let ended = 0;
  for (let row = 0; row < count; row += 1) {
    ended += arrays.terminated[row]! | arrays.truncated[row]!;
  }
  check("fingerprints", ended, 0); // 0: a server without fingerprints.
  const bytes = attached.pool!.observationBytes;
  const wantsFinals = body.case === "step" && body.value.withFinalObservations;
  check("finalObservations", wantsFinals ? ended * bytes : 0, 0);
  const encoding = attached.pool!.spec!.encoding;
  if (observation === Observation.NONE || encoding === Encoding.RAW || encoding === Encoding.UNSPECIFIED) {
    check("observations", observation === Observation.NONE ? 0 : count * bytes);
  } else if (arrays.observations.length === 0 || count * bytes > attached.responseBytesMax) {
    // The server sizes responses by raw observations, so the decoded size is bounded.
    throw wrong(
      `request ${number}: ${arrays.observations.length} bytes of ${count} encoded observations`,
      `some, of up to ${attached.responseBytesMax} bytes when decoded`,
    );
  }
}

// A page of snapshots of `environments`, after `before` snapshots on earlier pages.
export function checkStates(page: SaveStatesResponse, environments: readonly number[], before: number): void {
  const count = before + page.states.length;
  const isLast = page.nextPageToken === "";
  if (page.states.length === 0 || count > environments.length || isLast !== (count === environments.length)) {
    const more = isLast ? "" : " and more to come";
    throw wrong(`${page.states.length} states after ${before}${more}`, `${environments.length} in all`);
  }
  for (const [i, { environment, snapshot }] of page.states.entries()) {
    if (environment !== environments[before + i] || snapshot.length < 1 || snapshot.length > snapshotBytesMax) {
      throw wrong(
        `a snapshot of ${snapshot.length} bytes of environment ${environment}`,
        `1 to ${snapshotBytesMax} of ${environments[before + i]}`,
      );
    }
  }
}

// Frames of `environments` in this order, raw RGB.
export function checkFrames(frames: readonly Frame[], environments: readonly number[], sizePx: number): void {
  if (frames.length !== environments.length) {
    throw wrong(`${frames.length} frames`, environments.length);
  }
  for (const [i, { environment, sizePx: size, image }] of frames.entries()) {
    if (environment !== environments[i] || size !== sizePx || image.length !== 3 * sizePx ** 2) {
      throw wrong(
        `a frame of environment ${environment} of ${size} x ${size} pixels in ${image.length} bytes`,
        `${environments[i]} and a square of ${sizePx}`,
      );
    }
  }
}
