// Draws views of a play: images and figures.

import { byId, setTiles } from "../elements/elements.js";
import { count, reward } from "../elements/figures.js";
import { drawImage } from "../elements/pictures.js";

// `isEnd`: shows the last frames of the episode that has ended. `isCurrent()`: whether the view is still shown when its images are
// ready, so that figures and images show the same step.
export async function drawView({ game }, view, isEnd, isCurrent) {
  const images = isEnd ? view.finalImages : view.images;
  await Promise.all(["human", "agent"].map((name) => drawImage(byId(name), images[name])));
  if (!isCurrent()) {
    return;
  }
  const isStart = view.first && !isEnd;
  const [score, step] = isStart ? [0, 0] : [view.totalReward, view.episodeStep];
  const seed = isEnd ? view.prevLevelSeed : view.levelSeed;
  const where = `${game}, level ${seed}, step ${step}, score ${reward(score)}`;
  byId("human").setAttribute("aria-label", `${where}, as people see it`);
  byId("agent").setAttribute("aria-label", `${where}, as the agent sees it`);
  setTiles(byId("figures"), [
    ["Score", reward(score)], ["Step", count(step)], ["Level seed", String(seed)],
    ["Reward", reward(isStart ? 0 : view.reward)], ["Episodes", count(view.episodeCount)],
  ]);
}
