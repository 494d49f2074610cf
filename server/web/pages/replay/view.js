// Draws a frame of a replay: its images and figures.

import { byId, setText, setTiles } from "../elements/elements.js";
import { count, NONE, plural, reward } from "../elements/figures.js";
import { drawImage } from "../elements/pictures.js";
import { tellOptions } from "../links/level_choice.js";

// Describes what is replayed.
export function describe({ source, rows }, catalog) {
  const { games, mode, options, envCount: environments, environment } = source;
  const place = environments > 1 ? [`environment ${environment} of ${environments}`] : [];
  return [games.join(", "), mode, ...place, plural(rows - 1, "step"), ...tellOptions(options, catalog)].join(" · ");
}

// Shows whether the replay equals the recording.
export function judge(difference) {
  const verdict = byId("verdict");
  verdict.className = `badge ${difference ? "bad" : "on"}`;
  setText(verdict, difference
    ? `Differs at step ${difference.row}: ${difference.field} is ${difference.got}, was ${difference.expected}`
    : "Identical to the recording");
}

// Whether a frame is the end of an episode, which has images of its own.
function isEnd(view, { isStart }) {
  return view.first && !isStart;
}

// The image of a frame. `name`: "human" or "agent".
export function imageOf(view, frame, name) {
  return (isEnd(view, frame) ? view.finalImages ?? view.images : view.images)[name];
}

// `actionNames`: names by number. Returns false if `isCurrent()` is false when the images are drawn: the replay was closed.
export async function drawFrame(replay, view, frame, actionNames, isCurrent) {
  const { row, isStart } = frame;
  // First, so that figures and images show the same step.
  await Promise.all(["human", "agent"].map((name) => drawImage(byId(name), imageOf(view, frame, name))));
  if (!isCurrent()) {
    return false;
  }
  const action = isStart ? undefined : replay.source.actions[row - 1];
  const score = isStart ? 0 : view.totalReward;
  setTiles(byId("figures"), [
    ["Step", `${count(row)} of ${count(replay.rows - 1)}`], ["Action", actionNames.get(action) ?? action ?? NONE],
    ["Reward", isStart ? NONE : reward(view.reward)], ["Score", reward(score)],
    ["Level seed", String(isEnd(view, frame) ? view.prevLevelSeed : view.levelSeed)], ["Episode", episodeOf(view, frame)],
    ["Fingerprint", view.fingerprint ?? replay.recording.fingerprints.at(-1) ?? NONE],
  ]);
  const where = `step ${row}, score ${reward(score)}${row > 0 && isStart ? ", next episode" : ""}`;
  byId("row").setAttribute("aria-valuetext", where);
  byId("human").setAttribute("aria-label", `${where}, as people see it`);
  byId("agent").setAttribute("aria-label", `${where}, as the agent sees it`);
  return true;
}

// A frame in one line: its step, action, reward and score.
export function frameText({ recording }, { row, isStart }, actionNames) {
  if (isStart) {
    return `Step ${row}, start of an episode`;
  }
  const { reward: gained, totalReward } = recording.viewOf(row);
  const action = recording.actions[row - 1];
  return `Step ${row}, ${actionNames.get(action) ?? action}, reward ${reward(gained)}, score ${reward(totalReward)}`;
}

function episodeOf(view, frame) {
  if (isEnd(view, frame)) {
    return view.prevLevelComplete ? "complete" : "over";
  }
  return frame.isStart ? "start" : "running";
}
