// The ends of episodes in watched pools: the last frame of an episode is held for a while, with its result.

import { element } from "../elements/elements.js";
import { plural, reward } from "../elements/figures.js";

// Shows the frames of one environment.
export class EndHold {
  #draw;
  #holdMs;
  #timer = null;  // while the end of an episode is held
  #next = null;   // the newest frame that arrived meanwhile

  // `draw(frame)` shows a frame. The last frame of an episode stays for `holdMs`, or longer if no other arrives.
  constructor(holdMs, draw) {
    this.#holdMs = holdMs;
    this.#draw = draw;
  }

  show(frame) {
    if (this.#timer !== null) {
      // An end within the time is skipped, so that the start of the next episode is seen.
      this.#next = frame.endedEpisode ? this.#next : frame;
      return;
    }
    this.#draw(frame);
    if (frame.endedEpisode) {
      this.#timer = setTimeout(() => this.#release(), this.#holdMs);
    }
  }

  // Forgets the frame that waits.
  clear() {
    clearTimeout(this.#timer);
    this.#timer = null;
    this.#next = null;
  }

  #release() {
    const next = this.#next;
    this.clear();
    if (next) {
      this.#draw(next);
    }
  }
}

// How an episode ended: a word for the style sheet, a mark and a text.
const COMPLETE = ["complete", "✓", "Level complete"];
const LIMIT = ["limit", "◷", "Time limit"];
const OVER = ["over", "✕", "Episode over"];

function outcomeOf({ levelComplete: isComplete, truncated }) {
  return isComplete ? COMPLETE : truncated ? LIMIT : OVER;
}

// Marks `frame`, which surrounds a canvas, with the result of an episode: a coloured edge and, in its last child, a text, which
// is short for a small frame. Without an episode it removes them.
export function markEnd(frame, episode, isShort = false) {
  frame.querySelector(".result")?.remove();
  if (!episode) {
    delete frame.dataset.ended;
    return;
  }
  const [word, mark, text] = outcomeOf(episode);
  frame.dataset.ended = word;
  const result = isShort ? `${mark} ${reward(episode.return)}`
    : `${mark} ${text}: return ${reward(episode.return)} in ${plural(episode.length, "step")}`;
  frame.append(element("span", { class: "result" }, result));
}
