// The map of a replay: the whole level and the path of the agent through it, beside the views.

import { byId, setText } from "../elements/elements.js";
import { drawImage } from "../elements/pictures.js";
import { attempt } from "../page.js";

const SIZE_PX = 512;
const AGENT_RADIUS_PX = 6;

export class LevelMap {
  #source;
  #wanted = null;    // the newest frame
  #isBusy = false;
  #box = byId("map");

  // `source()` returns { replay }, a ReplayRun or null.
  constructor(source) {
    this.#source = source;
    this.#box.addEventListener("toggle", () => this.#draw());
  }

  // Shows a frame of the replay, unless a newer one follows.
  show(frame) {
    this.#wanted = frame;
    this.#draw();
  }

  // Forgets the replay.
  close() {
    this.#wanted = null;
  }

  async #draw() {
    if (this.#isBusy || !this.#box.open) {
      return;
    }
    this.#isBusy = true;
    for (let drawn = null; this.#wanted !== null && this.#wanted !== drawn && this.#box.open;) {
      drawn = this.#wanted;
      await this.#drawFrame(drawn);
    }
    this.#isBusy = false;
  }

  async #drawFrame({ row, isStart }) {
    const { replay } = this.#source();
    if (!replay) {
      return;
    }
    // Where an episode has ended, the map shows the level before the end, not that of the next episode.
    const isEnd = !isStart && replay.recording.isEnd(row);
    const map = await attempt(() => replay.map(isEnd ? row - 1 : row, SIZE_PX), () => {});
    if (map && replay === this.#source().replay) {
      await drawImage(byId("map-picture"), map.image);
      drawPath(byId("map-picture"), map, row);
      setText(byId("map-about"), `Level ${map.levelSeed}: where the agent has been up to this step, and where it goes next.`);
    }
  }
}

// Draws the path up to `row` as a line, the rest as a thin one, and the agent's place.
function drawPath(canvas, { firstRow, places }, row) {
  const context = canvas.getContext("2d");
  const now = Math.min(row - firstRow, places.length - 1);
  const trace = (from, to, width, color) => {
    context.beginPath();
    for (let i = from; i <= to; i += 1) {
      context.lineTo(places[i].x * canvas.width, places[i].y * canvas.height);
    }
    context.lineWidth = width;
    context.strokeStyle = color;
    context.stroke();
  };
  context.lineJoin = "round";
  trace(now, places.length - 1, 1.5, "#fffc");
  trace(0, now, 5, "#000a");
  trace(0, now, 2.5, "#ffd83d");
  context.beginPath();
  context.arc(places[now].x * canvas.width, places[now].y * canvas.height, AGENT_RADIUS_PX, 0, 2 * Math.PI);
  context.fillStyle = "#ffd83d";
  context.fill();
  context.lineWidth = 2;
  context.strokeStyle = "#000";
  context.stroke();
}
