// The table of the cluster's nodes, including recently lost ones.

import { element, setText } from "../elements/elements.js";
import { clock, count, NONE, rate } from "../elements/figures.js";
import { notify } from "../elements/notices.js";

const GONE_SHOWN_S = 600;
const STATE = 2;  // its column
const NUMBERS_FROM = 3;
const NUMBERS_TO = 7;
const COLUMN_COUNT = 8;

export class NodeTable {
  #body;
  #known = new Map();  // name -> { node, seen: time of the last report }
  #time = 0;

  constructor(body) {
    this.#body = body;
  }

  // Shows the nodes that the server lists at `time`.
  draw(nodes, time) {
    nodes.forEach((node) => this.#known.set(node.name, { node, seen: time }));
    for (const [name, { node, seen }] of this.#known) {
      if (seen < time - GONE_SHOWN_S) {
        this.#known.delete(name);
      } else if (seen === this.#time && seen < time) {
        notify(`${nameOf(node)} was lost.`, "warn");
      }
    }
    this.#time = time;
    this.#drawRows(stateOf);
  }

  // Shows that the states of the nodes are not known.
  lose() {
    this.#drawRows(null);
  }

  // `describe(node)` returns the state of a listed node; null: not known.
  #drawRows(describe) {
    const known = [...this.#known.values()].sort((one, other) => collator.compare(one.node.name, other.node.name));
    while (this.#body.rows.length > known.length) {
      this.#body.deleteRow(-1);
    }
    known.forEach(({ node, seen }, index) => {
      const row = this.#body.rows[index] ?? this.#body.appendChild(makeRow());
      const isListed = seen === this.#time;
      const state = isListed ? describe?.(node) ?? ["warn", "unknown"] : ["bad", `gone since ${clock(seen)}`];
      drawRow(row, node, state, isListed && describe !== null);
    });
  }
}

// Natural order: node-2 before node-10.
const collator = new Intl.Collator("en", { numeric: true });

function makeRow() {
  const cells = Array.from({ length: COLUMN_COUNT }, (_, column) =>
    element("td", { class: column >= NUMBERS_FROM && column < NUMBERS_TO ? "number" : null }, element("span")));
  return element("tr", {}, ...cells);
}

function drawRow(row, node, [kind, state], isThere) {
  const figures = isThere
    ? [environmentsOf(node), count(node.poolCount), count(node.workerCount), rate(node.stepsPerSecond)]
    : [NONE, NONE, NONE, NONE];
  [nameOf(node), node.address, state, ...figures, node.serverVersion].forEach((text, column) =>
    setText(row.cells[column].firstChild, text));
  row.cells[STATE].firstChild.className = `badge ${kind}`;
}

function nameOf({ name }) {
  return name.replace(/^nodes\//, "");
}

function environmentsOf({ envCount: held, environmentCapacity: most }) {
  return `${count(held)} of ${count(most)}`;
}

// The state of a listed node, as a badge class and a text.
function stateOf({ draining, healthy }) {
  if (draining) {
    return ["warn", "draining"];
  }
  return healthy ? ["on", "healthy"] : ["bad", "not serving"];
}
