// Programs in Python that play a level, or repeat a replay up to a step.

const LINE_LENGTH = 100;
// Options that a program always sets, because the engine would otherwise choose the levels.
const LEVEL_OPTIONS = ["num_levels", "start_level", "rand_seed"];

function literal(value) {
  if (typeof value === "boolean") {
    return value ? "True" : "False";
  }
  return JSON.stringify(value);
}

// Wraps the items of a list or call, with this indentation.
function wrapped(items, indentation) {
  const lines = [];
  for (const item of items) {
    const last = lines.at(-1);
    if (last && last.length + item.length + 3 <= LINE_LENGTH) {
      lines[lines.length - 1] = `${last} ${item},`;
    } else {
      lines.push(`${indentation}${item},`);
    }
  }
  return lines.join("\n");
}

// The arguments of Pool, without those at their defaults.
function argumentsOf({ games, mode, options, envCount: all = 1, environment = 0 }, catalog) {
  const others = catalog.options
    .filter(({ name, default: usual }) => name in options && options[name] !== usual);
  return [
    literal(games.length === 1 ? games[0] : games), "1",
    ...(all > 1 ? [`first_env=${environment}`, `total_env_count=${all}`] : []),
    `distribution_mode=${literal(mode)}`, ...[...LEVEL_OPTIONS, ...others.map(({ name }) => name)].map((name) => `${name}=${literal(options[name])}`),
  ];
}

// `address`: of this server, for programs.
function program(comment, header, { catalog, address }, body) {
  return `from procgen_client import Pool

# ${comment} It is stepped in this process; with server=${literal(address)}, on the server of the page.
pool = Pool(
${wrapped(argumentsOf(header, catalog), "    ")}
)
with pool:
${body.map((line) => `    ${line}\n`).join("")}`;
}

// A program that shows the start of a level: { game, mode, level, options }.
// `hello`: see page.js.
export function levelProgram({ game, mode, level, options }, hello) {
  const { catalog } = hello;
  const modes = catalog.games.find(({ name }) => name === game).modes;
  const isOnly = modes.find(({ name }) => name === mode).levelSeed !== undefined;
  const all = { ...options, num_levels: isOnly ? 0 : 1, start_level: isOnly ? 0 : level, rand_seed: 0 };
  return program(`${game}, ${mode}, level ${level}.`, { games: [game], mode, options: all }, hello, [
    "batch = pool.observe()", "observation = batch.observations[0]  # uint8 [64, 64, 3]",
    "print(batch.level_seeds[0], observation.shape)",
  ]);
}

// A program that repeats a replay up to a frame, whose observation it has at the end. `isEnd`: it is the last of its episode.
export function replayProgram({ source, name, row, isEnd }, hello) {
  const actions = source.actions.slice(0, row).map(String);
  const list = actions.length === 0 ? "[]" : `[\n${wrapped(actions, "        ")}\n    ]`;
  return program(`${name}: ${row} of ${source.actions.length} steps.`, source, hello, [
    `actions = ${list}`,
    "batch = pool.observe()",
    "for action in actions:", "    batch = pool.step([action], final_observations=True)",
    isEnd ? "observation = batch.final_observations[0]  # the last of the episode, uint8 [64, 64, 3]"
      : "observation = batch.observations[0]  # uint8 [64, 64, 3]",
    "print(batch.level_seeds[0], batch.rewards[0], batch.fingerprints[0])",
  ]);
}
