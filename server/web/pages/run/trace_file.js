// Trace files: one line of JSON, then arrays (envcore/trace/README.md).

import { UserError } from "../connection/errors.js";
import { areOptions, numberOfMode } from "./options.js";

const FORMAT = "procgen-trace-1";
const NEWLINE = 10;
const END_EPISODE_BYTE = 255;
const END_EPISODE = -1;

const TYPES = {
  u1: { size: 1, get: "getUint8", set: "setUint8" }, f4: { size: 4, get: "getFloat32", set: "setFloat32" },
  i4: { size: 4, get: "getInt32", set: "setInt32" }, u4: { size: 4, get: "getUint32", set: "setUint32" },
};

function damaged(message) {
  return new UserError("DATA_LOSS", `The file is not a trace: ${message}.`);
}

function headerOf(bytes) {
  const end = bytes.indexOf(NEWLINE);
  let header = null;
  try {
    header = JSON.parse(new TextDecoder().decode(bytes.subarray(0, end < 0 ? bytes.length : end)));
  } catch {
    throw damaged("its first line is not JSON");
  }
  if (header?.format !== FORMAT) {
    throw damaged(`its format is ${JSON.stringify(header?.format)}, must be ${FORMAT}`);
  }
  header.options = { variant: "", ...header.options };  // only traces with a variant name it
  const { options, num_envs: envCount, steps, arrays } = header;
  if (!(Number.isInteger(envCount) && envCount > 0 && Number.isInteger(steps) && steps >= 0 && Array.isArray(arrays))) {
    throw damaged("num_envs, steps or arrays is missing");
  }
  if (typeof options?.env_name !== "string" || numberOfMode(options.distribution_mode) === 0 || !areOptions(options)) {
    throw damaged("an option is missing, or its value is not of its type");
  }
  return { header, start: end + 1 };
}

// The arrays after the header by name, each with `rows * envCount` values.
function arraysOf({ arrays, num_envs: envCount }, bytes, start) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.length);
  const values = {};
  let at = start;
  for (const [name, typeName, rows] of arrays) {
    const type = TYPES[typeName];
    if (!type || !(rows >= 0) || at + rows * envCount * type.size > bytes.length) {
      throw damaged(`it ends within array ${name}, which has ${rows} rows of type ${typeName}`);
    }
    values[name] = Array.from({ length: rows * envCount }, (_, i) => view[type.get](at + i * type.size, true));
    at += rows * envCount * type.size;
  }
  return values;
}

// Reads a trace of `envCount` environments: { games, mode, options, envCount, steps, column(name, environment), fingerprints(environment) }.
// Throws a UserError.
export function readTrace(bytes) {
  const { header, start } = headerOf(bytes);
  const { num_envs: envCount, steps } = header;
  const arrays = arraysOf(header, bytes, start);
  for (const name of ["action", "reward", "first", "level_seed", "prev_level_seed", "prev_level_complete"]) {
    const rows = name === "action" ? steps : steps + 1;
    if (arrays[name]?.length !== rows * envCount) {
      throw damaged(`array ${name} must have ${rows} rows of ${envCount}`);
    }
  }
  const { env_name: games, distribution_mode: mode, ...options } = header.options;
  const column = (name, environment) => arrays[name].filter((_, i) => i % envCount === environment);
  return {
    games: games.split(","), mode, options, envCount, steps,
    actions: (environment) => column("action", environment).map((byte) => (byte === END_EPISODE_BYTE ? END_EPISODE : byte)),
    column, fingerprints: (environment) => header.fingerprints?.[environment] ?? null,
  };
}

// Writes a Recording as a trace of one environment.
export function writeTrace(recording) {
  const { games, mode, options: { variant, ...upstreams } } = recording;
  const options = variant ? { ...upstreams, variant } : upstreams;
  const columns = [
    ["action", "u1", recording.actions], ["reward", "f4", recording.rewards], ["first", "u1", recording.first],
    ["level_seed", "i4", recording.levelSeeds], ["prev_level_seed", "i4", recording.prevLevelSeeds],
    ["prev_level_complete", "u1", recording.prevLevelComplete],
  ];
  const header = {
    format: FORMAT, options: { env_name: games.join(","), distribution_mode: mode, ...options }, num_envs: 1, steps: recording.rows - 1,
    arrays: columns.map(([name, type, values]) => [name, type, values.length]), fingerprints: [recording.fingerprints],
  };
  const line = new TextEncoder().encode(`${JSON.stringify(header)}\n`);
  const bytes = new Uint8Array(columns.reduce((sum, [, type, values]) => sum + values.length * TYPES[type].size, line.length));
  bytes.set(line);
  const view = new DataView(bytes.buffer);
  let at = line.length;
  for (const [, name, values] of columns) {
    const type = TYPES[name];
    for (const value of values) {
      view[type.set](at, Number(value), true);  // -1 becomes 255
      at += type.size;
    }
  }
  return bytes;
}
