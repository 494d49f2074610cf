// Draws the rewards of a replay over its frames: gains upwards, losses downwards, a line at the end of each episode.

import { colorsOf } from "../elements/colors.js";

// `marked`: a row that differs from another replay, or null.
export function drawTimeline(canvas, { recording, difference }, frames, shown = 0, marked = null) {
  const scale = devicePixelRatio;
  const width = canvas.clientWidth;
  const height = canvas.clientHeight;
  canvas.width = Math.round(width * scale);
  canvas.height = Math.round(height * scale);
  const context = canvas.getContext("2d");
  context.scale(scale, scale);
  const { edge, good, bad, warn, accent } = colorsOf("edge", "good", "bad", "warn", "accent");
  const at = (frame) => frame / Math.max(1, frames.last) * (width - 2) + 1;
  const bar = (frame, top, size, color, thickness = 2) => {
    context.fillStyle = color;
    context.fillRect(at(frame) - thickness / 2, top, thickness, size);
  };

  const middle = height / 2;
  bar(frames.last / 2, middle, 1, edge, width);
  recording.starts.forEach((row) => bar(frames.ofRow(row), 0, height, edge, 1));
  const largest = recording.rewards.reduce((most, value) => Math.max(most, Math.abs(value)), 0) || 1;
  recording.rewards.forEach((value, row) => {
    const size = Math.max(3, Math.abs(value) / largest * (middle - 3));
    if (value > 0) {
      bar(frames.ofRow(row), middle - size, size, good, 3);
    } else if (value < 0) {
      bar(frames.ofRow(row), middle, size, bad, 3);
    }
  });
  if (difference) {
    bar(frames.ofRow(difference.row), 0, height, bad, 3);
  }
  if (marked !== null) {
    bar(frames.ofRow(marked), 0, height, warn, 5);
  }
  bar(shown, 0, height, accent);
}
