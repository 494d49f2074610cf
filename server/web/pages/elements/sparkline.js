// A small line without axes, for the cells of a table.

const WIDTH = 72;
const HEIGHT = 20;
const MARGIN = 2;

export function makeSparkline() {
  const drawing = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  drawing.setAttribute("viewBox", `0 0 ${WIDTH} ${HEIGHT}`);
  drawing.setAttribute("role", "img");
  drawing.setAttribute("class", "sparkline");
  drawing.append(document.createElementNS("http://www.w3.org/2000/svg", "polyline"));
  return drawing;
}

// Draws values, evenly spaced, without the missing ones. `name` describes them.
export function drawSparkline(drawing, values, name) {
  const known = values.flatMap((value, index) => (value === null ? [] : [[index, value]]));
  const low = Math.min(...known.map(([, value]) => value));
  const span = Math.max(...known.map(([, value]) => value)) - low;
  const points = known.map(([index, value]) => {
    const x = MARGIN + (WIDTH - 2 * MARGIN) * (index / Math.max(values.length - 1, 1));
    const y = span === 0 ? HEIGHT / 2 : HEIGHT - MARGIN - (HEIGHT - 2 * MARGIN) * ((value - low) / span);
    return `${x.toFixed(1)},${y.toFixed(1)}`;
  });
  drawing.firstChild.setAttribute("points", points.join(" "));
  drawing.setAttribute("aria-label", name);
}
