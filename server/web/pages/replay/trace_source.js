// Traces as sources of replays (see replay_run.js).

import { UserError } from "../connection/errors.js";
import { readTrace } from "../run/trace_file.js";

const ACTION_MIN = -1;
const ACTION_MAX = 14;

// The columns that are compared: their names in traces and in a Recording.
const COLUMNS = [
  ["reward", "rewards"], ["first", "first"], ["level_seed", "levelSeeds"], ["prev_level_seed", "prevLevelSeeds"],
  ["prev_level_complete", "prevLevelComplete"],
];

// The source of a trace file's environment. Throws a UserError for bytes that are no trace.
export function sourceOfTrace(bytes, environment = 0) {
  const trace = readTrace(bytes);
  const { games, mode, options, envCount } = trace;
  const actions = trace.actions(environment);
  const unknown = actions.find((action) => action < ACTION_MIN || action > ACTION_MAX);
  if (unknown !== undefined) {
    throw new UserError("INVALID_ARGUMENT", `The trace has action ${unknown}, allowed: ${ACTION_MIN} to ${ACTION_MAX}.`);
  }
  const first = trace.column("first", environment);
  return {
    games, mode, options, envCount, environment, actions, annotations: [], rowOfStep: (step) => step + 1,
    endsAfter: (index) => first[index + 1] !== 0,
    check: (recording) => differenceOf(trace, environment, recording),
  };
}

// The first difference of a replay from its trace: { row, field, expected, got }; null if they are identical.
function differenceOf(trace, environment, recording) {
  const differences = COLUMNS.flatMap(([field, member]) => {
    const expected = trace.column(field, environment);
    const got = recording[member].map(Number);
    const row = expected.findIndex((value, i) => !Object.is(value, got[i]));
    return row < 0 ? [] : [{ row, field, expected: expected[row], got: got[row] }];
  });
  if (differences.length > 0) {
    return differences.reduce((first, each) => (each.row < first.row ? each : first));
  }
  const expected = trace.fingerprints(environment);
  const got = recording.fingerprints;
  return expected === null || expected.join() === got.join() ? null
    : { row: recording.rows - 1, field: "fingerprint", expected: expected.at(-1) ?? null, got: got.at(-1) ?? null };
}
