// Draws views of a play: images and figures.

import { byId, setTiles } from "../elements/elements.js";
import { count, reward } from "../elements/figures.js";
import { drawPart, partOf } from "../elements/pictures.js";

// `kind`: "final_" for the last frames of an episode that has ended, else "". `isCurrent()`: whether the view is still shown when
// its images are ready, so that figures and images show the same step.
export async function drawView({ game }, view, kind, isCurrent) {
  await Promise.all(["human", "agent"].map((name) => drawPart(byId(name), partOf(view, kind + name))));
  if (!isCurrent()) {
    return;
  }
  const isStart = view.first && kind === "";
  const [score, step] = isStart ? [0, 0] : [view.total_reward, view.episode_step];
  const seed = kind === "" ? view.level_seed : view.prev_level_seed;
  const where = `${game}, level ${seed}, step ${step}, score ${reward(score)}`;
  byId("human").setAttribute("aria-label", `${where}, as people see it`);
  byId("agent").setAttribute("aria-label", `${where}, as the agent sees it`);
  setTiles(byId("figures"), [
    ["Score", reward(score)], ["Step", count(step)], ["Level seed", String(seed)],
    ["Reward", reward(isStart ? 0 : view.reward)], ["Episodes", count(view.episode_count)],
  ]);
}
