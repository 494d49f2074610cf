// Recorded episodes of pools, as sources of replays.

import { UserError } from "../connection/errors.js";
import { fingerprintText } from "./environment.js";
import { optionsOf } from "./options.js";

const SELECTOR_LAST = 1;
const SELECTOR_CURRENT = 2;
const OUTCOME_UNDER_WAY = 1;
const OUTCOME_RESET = 4;
const END_EPISODE_BYTE = 255;
const END_EPISODE = -1;

// Why the start of an episode is missing, by number of IncompleteReason.
const INCOMPLETE = [null, "a state was restored during the episode",
  "the episode began too long ago, and its first steps were dropped (limit episode_history_bytes_max)"];

// Requests an episode. `episode`: the fingerprint of one that ended, or "last" or "current". Rejects with a UserError.
export async function fetchEpisode(connection, { pool, environment, episode }) {
  const isFingerprint = /^[0-9a-f]{16}$/.test(episode);
  if (!isFingerprint && episode !== "last" && episode !== "current") {
    throw new UserError("INVALID_ARGUMENT", `episode is “${episode}”, allowed: 16 hexadecimal digits`);
  }
  const message = await connection.call("PoolService.GetEpisode", {
    pool, environment, selector: episode === "current" ? SELECTOR_CURRENT : SELECTOR_LAST,
    fingerprint: isFingerprint ? BigInt.asIntN(64, BigInt(`0x${episode}`)) : 0n,
  });
  if (message.incompleteReason !== 0) {
    throw new UserError("FAILED_PRECONDITION",
      `the beginning of this episode is missing: ${INCOMPLETE[message.incompleteReason] ?? "the reason is unknown"}`);
  }
  if (message.levelSeed < 0) {
    throw new UserError("FAILED_PRECONDITION", `the episode began with level ${message.levelSeed}, which a trace cannot begin with`);
  }
  return message;
}

// What identifies an episode in links: { pool, environment, episode: fingerprint }; null if it has not ended, as it has no
// fingerprint yet.
export function placeOf({ pool, environment }, { fingerprint }) {
  return fingerprint === 0n ? null : { pool, environment, episode: fingerprintText(fingerprint) };
}

// An Episode as the source of a replay (see replay/replay_run.js).
export function sourceOfEpisode(episode) {
  const { mode, options } = optionsOf(episode.options);
  const hasEnd = episode.outcome !== OUTCOME_UNDER_WAY && episode.outcome !== OUTCOME_RESET;
  const actions = [...episode.actions].map((byte) => (byte === END_EPISODE_BYTE ? END_EPISODE : byte));
  const isSummed = episode.actionCounts.length > 0;
  return {
    games: [episode.game], mode, options, envCount: 1, environment: 0, actions, annotations: episode.annotations,
    rowOfStep: rowsOfSteps(episode),
    endsAfter: (index) => hasEnd && index === actions.length - 1,
    check: (recording) => checkEpisode(episode, recording, isSummed ? null : episode.rewards),
  };
}

// Returns the function that maps a learner's step to the row that it led to: after all of its actions.
function rowsOfSteps({ actionCounts }) {
  if (actionCounts.length === 0) {
    return (step) => step + 1;
  }
  let row = 0;
  const rows = actionCounts.map((count) => { row += count; return row; });
  return (step) => rows[step];
}

// Throws a UserError if the replay differs from the episode: then its learner has chosen levels one by one. `rewards`: of each
// action, or null if they are not known.
function checkEpisode({ levelChanges }, recording, rewards) {
  const isSame = levelChanges.every(({ action, levelSeed }) => recording.levelSeeds[action + 1] === levelSeed)
    && (rewards === null || rewards.every((value, i) => Object.is(value, recording.rewards[i + 1])));
  if (!isSame) {
    throw chosenLevels();
  }
  return null;
}

export function chosenLevels() {
  return new UserError("FAILED_PRECONDITION", "the levels of this episode were selected individually, which a trace cannot represent");
}
