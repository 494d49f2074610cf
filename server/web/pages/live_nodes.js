// The table of the cluster's nodes.

import { element, setText } from "./elements.js";
import { count, rate } from "./figures.js";

const NUMBERS_FROM = 3;
const NUMBERS_TO = 7;

export function drawNodes(body, nodes) {
  while (body.rows.length > nodes.length) {
    body.deleteRow(-1);
  }
  nodes.forEach((node, row) => {
    const cells = cellsOf(node);
    const line = body.rows[row] ?? body.appendChild(element("tr", {}, ...cells.map((_, column) =>
      element("td", { class: column >= NUMBERS_FROM && column < NUMBERS_TO ? "number" : null }))));
    cells.forEach((text, column) => setText(line.cells[column], text));
  });
}

function cellsOf(node) {
  const state = node.draining ? "draining" : node.healthy ? "healthy" : "not answering";
  return [
    `${node.name.replace(/^nodes\//, "")}${node.role === "fleet" ? " (fleet)" : ""}`, node.address, state,
    `${count(node.environment_count)} of ${count(node.environment_capacity)}`, count(node.pool_count),
    count(node.worker_count), rate(node.steps_per_second), node.version,
  ];
}
