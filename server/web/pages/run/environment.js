// A pool of one environment that a page steps. Requests may be sent ahead.

import { PoolStream } from "./pool_stream.js";

export const AGENT_SIZE_PX = 64;

const SLICE = { firstEnv: 0, envCount: 1 };
const OBSERVATION_NONE = 1;
const FRAME_VIEW_HUMAN = 1;
const FRAME_VIEW_LEVEL = 3;
const FRAME_FORMAT_PNG = 2;
const FRAME_FORMAT_NONE = 3;

export class Environment {
  #pool;

  // `spec`: see spec.js; `kind`: see kinds.js.
  static async start(connection, kind, spec) {
    return new Environment(await PoolStream.start(connection, kind, spec));
  }

  constructor(pool) {
    this.#pool = pool;
  }

  // The spec of the pool, with every default.
  get spec() {
    return this.#pool.spec;
  }

  // Steps, or begins the next episode after the end of one. Resolves to the row.
  step(action) {
    return this.#pool.request("step", { slice: SLICE, actions: [action], observation: OBSERVATION_NONE }, rowOf);
  }

  // The row of the last step, with the agent's view as `agent`.
  observe() {
    return this.#pool.request("observe", { slice: SLICE }, rowOf);
  }

  // The view for people, as an image of this size.
  human(sizePx) {
    return this.#render(FRAME_VIEW_HUMAN, sizePx);
  }

  // The whole level, as an image.
  level(sizePx) {
    return this.#render(FRAME_VIEW_LEVEL, sizePx);
  }

  // Where the agent is in an image of the whole level: { x, y }, fractions from the top left corner.
  place() {
    return this.#pool.request("render", { environments: [0], view: FRAME_VIEW_LEVEL, format: FRAME_FORMAT_NONE },
      ({ frames: [{ agentPosition: { x, y } }] }) => ({ x, y }));
  }

  // A snapshot.
  save() {
    return this.#pool.request("saveStates", {}, ({ states: [state] }) => state);
  }

  restore(state) {
    return this.#pool.request("restoreStates", { states: [state] });
  }

  // Both views of the current state: { agent, human }.
  look(sizePx) {
    const views = Promise.all([this.observe(), this.human(sizePx)]).then(([{ agent }, human]) => ({ agent, human }));
    views.catch(() => {});  // as of other requests
    return views;
  }

  // Ends the pool.
  close() {
    this.#pool.close();
  }

  #render(view, sizePx) {
    return this.#pool.request("render", { environments: [0], sizePx, format: FRAME_FORMAT_PNG, view },
      ({ frames: [{ image, sizePx: size }] }) => ({ format: "png", width: size, height: size, content: image }));
  }
}

// A fingerprint as 16 hexadecimal digits.
export function fingerprintText(value) {
  return BigInt.asUintN(64, value).toString(16).padStart(16, "0");
}

// The only row of a batch. `hasEnded`: the step ended its episode, and the next one begins another.
function rowOf(batch) {
  return {
    reward: batch.rewards[0], isFirst: batch.first[0], hasEnded: batch.terminated[0] || batch.truncated[0],
    levelSeed: batch.levelSeeds[0], prevLevelSeed: batch.prevLevelSeeds[0], prevLevelComplete: batch.prevLevelComplete[0],
    episodeReturn: batch.episodeReturns[0], episodeLength: batch.episodeLengths[0],
    fingerprint: batch.fingerprints.length === 0 ? null : fingerprintText(batch.fingerprints[0]),
    agent: batch.images ? { format: "rgb", width: AGENT_SIZE_PX, height: AGENT_SIZE_PX, content: batch.images[0] } : null,
  };
}
