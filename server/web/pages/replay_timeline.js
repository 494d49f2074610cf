// Draws the rewards of a replay over its rows: gains upwards, losses downwards, a line at the start of each episode.

import { colorsOf } from "./colors.js";

export function drawTimeline(canvas, replay, row = 0) {
  const scale = devicePixelRatio;
  const width = canvas.clientWidth;
  const height = canvas.clientHeight;
  canvas.width = Math.round(width * scale);
  canvas.height = Math.round(height * scale);
  const context = canvas.getContext("2d");
  context.scale(scale, scale);
  const { edge, good, bad, accent } = colorsOf("edge", "good", "bad", "accent");
  const last = Math.max(1, replay.rows - 1);
  const at = (index) => index / last * (width - 2) + 1;
  const bar = (index, top, size, color, thickness = 2) => {
    context.fillStyle = color;
    context.fillRect(at(index) - thickness / 2, top, thickness, size);
  };

  const middle = height / 2;
  bar(last / 2, middle, 1, edge, width);
  replay.first.forEach((index) => bar(index, 0, height, edge, 1));
  const largest = replay.rewards.reduce((most, value) => Math.max(most, Math.abs(value)), 0) || 1;
  replay.rewards.forEach((value, index) => {
    const size = Math.max(3, Math.abs(value) / largest * (middle - 3));
    if (value > 0) {
      bar(index, middle - size, size, good, 3);
    } else if (value < 0) {
      bar(index, middle, size, bad, 3);
    }
  });
  if (replay.difference) {
    bar(replay.difference.row, 0, height, bad, 3);
  }
  bar(row, 0, height, accent);
}
