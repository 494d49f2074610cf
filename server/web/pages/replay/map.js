// The map of a replay: the whole level and the path of the agent through it, beside the views.

import { byId, setText } from "../elements/elements.js";
import { drawPart, partOf } from "../elements/pictures.js";
import { attempt } from "../page.js";

const SIZE_PX = 512;
const AGENT_RADIUS_PX = 6;

export class LevelMap {
  #source;
  #wanted = null;    // the newest frame
  #isBusy = false;
  #box = byId("map");

  // `source()` returns { connection, replay }.
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
    const { connection, replay } = this.#source();
    if (!connection || !replay) {
      return;
    }
    // At the end of an episode the server shows the start of the next one.
    const isEnd = !isStart && row > 0 && replay.first.includes(row);
    const request = { replay: replay.replay, row: isEnd ? row - 1 : row, map_size_px: SIZE_PX };
    const view = await attempt(() => connection.call("replay.seek", request), () => {});
    if (view && replay === this.#source().replay) {
      await drawPart(byId("map-picture"), partOf(view, "map"));
      drawPath(byId("map-picture"), view.path, row);
      setText(byId("map-about"), `Level ${view.level_seed}: where the agent has been up to this step, and where it goes next.`);
    }
  }
}

// Draws the path up to `row` as a line, the rest as a thin one, and the agent's place.
function drawPath(canvas, { first_row: firstRow, x, y }, row) {
  const context = canvas.getContext("2d");
  const now = Math.min(row - firstRow, x.length - 1);
  const trace = (from, to, width, color) => {
    context.beginPath();
    for (let i = from; i <= to; i += 1) {
      context.lineTo(x[i] * canvas.width, y[i] * canvas.height);
    }
    context.lineWidth = width;
    context.strokeStyle = color;
    context.stroke();
  };
  context.lineJoin = "round";
  trace(now, x.length - 1, 1.5, "#fffc");
  trace(0, now, 5, "#000a");
  trace(0, now, 2.5, "#ffd83d");
  context.beginPath();
  context.arc(x[now] * canvas.width, y[now] * canvas.height, AGENT_RADIUS_PX, 0, 2 * Math.PI);
  context.fillStyle = "#ffd83d";
  context.fill();
  context.lineWidth = 2;
  context.strokeStyle = "#000";
  context.stroke();
}
