// The table of pools: filter, order and comparison.

import { byId, element, setText } from "../elements/elements.js";
import { count, duration, plural, rate, reward } from "../elements/figures.js";
import { SortedHeader } from "../elements/tables.js";
import { addressOfPool, comparedPools, writeComparedPools } from "./settings.js";

const COMPARED_MAX = 8;
const IDLE_S = 5;  // without a step

const COLUMNS = [
  { title: "Pool", value: (pool) => titleOf(pool) },
  { title: "State", value: ({ state }) => state.rank },
  { title: "Game", value: (pool) => gamesOf(pool), write: (names) => names },
  { title: "Mode", value: ({ mode }) => mode, write: (mode) => mode },
  { title: "Environments", isNumber: true, value: ({ envCount: number }) => number, write: count },
  { title: "Steps / s", isNumber: true, value: ({ stepsPerSecond: number }) => number, write: rate },
  { title: "Return", isNumber: true, value: ({ meanReturn: number }) => number, write: reward },
  { title: "Episodes", isNumber: true, value: ({ episodeCount: number }) => number, write: rate },
  { title: "Age", isNumber: true, value: ({ ageS: age }) => age, write: duration },
  { title: "Compare" },
];

// The name of a pool for people.
export function titleOf({ displayName, name }) {
  return displayName || name;
}

// The labels of a pool as texts, in order: ["seed=3"].
export function labelsOf({ labels }) {
  return Object.entries(labels).map(([key, value]) => `${key}=${value}`).sort();
}

function gamesOf({ games }) {
  const names = [...new Set(games)];
  return names.length > 3 ? `${names.length} games` : names.join(", ");
}

// The state of a pool at `time`: a text, the class of its badge, and its place in the order. `isUnknown`: the connection broke.
export function stateOf({ isUnknown, paused, lastStepTimeS: stepped }, time) {
  if (isUnknown) {
    return { text: "unknown", kind: "warn", rank: 3 };
  }
  if (paused) {
    return { text: "paused", kind: "warn", rank: 1 };
  }
  if (stepped === null) {
    return { text: "never stepped", kind: "", rank: 2 };
  }
  if (stepped === undefined) {
    return { text: "idle", kind: "warn", rank: 1 };  // Since when is not known yet.
  }
  const idle = time - stepped;
  return idle > IDLE_S ? { text: `idle for ${duration(idle)}`, kind: "warn", rank: 1 } : { text: "running", kind: "on", rank: 0 };
}

export class PoolTable {
  #pools = [];
  #open = null;          // name
  #rows = new Map();     // name -> row
  #compared = new Set(comparedPools());  // names, without the open pool
  #header = new SortedHeader(byId("pool-columns"), COLUMNS, "State", false, () => this.#arrange());
  #onOpen;
  #onCompare;

  // `onOpen(event)`: a pool's link was clicked; `onCompare(names)`: others are compared with the open pool.
  constructor(onOpen, onCompare) {
    this.#onOpen = onOpen;
    this.#onCompare = onCompare;
    byId("pool-filter").addEventListener("input", () => this.#arrange());
    onCompare([...this.#compared]);
  }

  // Shows the pools of a report at `time`; `open` is the name of the open one.
  draw(pools, time, open) {
    this.#pools = pools.map((pool) => ({
      ...pool,
      ageS: time - pool.createTimeS,
      state: stateOf(pool, time),
    })).reverse();
    byId("pools-head").hidden = byId("pool-list").hidden = pools.length === 0;
    const isOther = open !== this.#open;
    this.#open = open;
    this.#forgetClosed();
    this.#pools.forEach((pool) => this.#drawRow(pool));
    // Rows stay where they are while the user is about to press one.
    const isNew = byId("pools").childElementCount === 0 || this.#pools.some(({ name }) => !this.#rows.get(name).isConnected);
    if (isNew || isOther || !byId("pools").matches(":hover, :focus-within")) {
      this.#arrange();
    }
    if (isOther) {
      this.#scrollToOpen();
    }
  }

  #forgetClosed() {
    const names = new Set(this.#pools.map(({ name }) => name));
    for (const [name, row] of this.#rows) {
      if (!names.has(name)) {
        row.remove();
        this.#rows.delete(name);
        this.#compare(name, false);
      }
    }
    this.#compare(this.#open, false);
  }

  // Shows the rows that match the filter, in the chosen order.
  #arrange() {
    const words = byId("pool-filter").value.toLowerCase().split(/\s+/);
    const shown = this.#header.sort(this.#pools).filter((pool) => {
      const text = [pool.name, pool.displayName, ...labelsOf(pool), ...pool.games, pool.mode, pool.owner, pool.state.text].join(" ").toLowerCase();
      return words.every((word) => text.includes(word));
    }).map(({ name }) => this.#rows.get(name));
    const list = byId("pools");
    if (shown.length !== list.childElementCount || shown.some((row, index) => list.children[index] !== row)) {
      const focused = list.querySelector(":focus");
      list.replaceChildren(...shown);
      focused?.focus({ preventScroll: true });
    }
    setText(byId("pools-none"), this.#pools.length > 0 && shown.length === 0 ? "No pool matches the filter." : "");
    setText(byId("pools-count"), shown.length === this.#pools.length ? plural(shown.length, "pool")
      : `${count(shown.length)} of ${plural(this.#pools.length, "pool")}`);
  }

  #makeRow(pool) {
    const { name } = pool;
    const compare = element("input", {
      type: "checkbox", "aria-label": `Compare ${name}`, onchange: ({ target }) => this.#compare(name, target.checked),
    });
    const cells = COLUMNS.map(({ isNumber, title }) => element("td", { class: isNumber ? "number" : null }, {
      Pool: element("a", { href: addressOfPool(name), onclick: this.#onOpen }, titleOf(pool)),
      State: element("span"), Compare: compare,
    }[title]));
    return element("tr", {}, ...cells);
  }

  #drawRow(pool) {
    if (!this.#rows.has(pool.name)) {
      this.#rows.set(pool.name, this.#makeRow(pool));
    }
    const row = this.#rows.get(pool.name);
    const cell = (title) => row.cells[COLUMNS.findIndex((column) => column.title === title)];
    setText(cell("State").firstChild, pool.state.text);
    cell("State").firstChild.className = `badge ${pool.state.kind}`;
    COLUMNS.filter(({ write }) => write).forEach(({ title, value, write }) => setText(cell(title), write(value(pool))));
    cell("Game").title = pool.games.join(", ");
    const isOpen = pool.name === this.#open;
    row.classList.toggle("open", isOpen);
    const link = cell("Pool").firstChild;
    link.title = [pool.name, ...labelsOf(pool), ...(pool.owner ? [`owner ${pool.owner}`] : [])].join(", ");
    link.href = addressOfPool(pool.name);
    if (isOpen) {
      link.setAttribute("aria-current", "true");
    } else {
      link.removeAttribute("aria-current");
    }
    const box = cell("Compare").firstChild;
    box.checked = isOpen || this.#compared.has(pool.name);
    box.disabled = isOpen || (!box.checked && this.#compared.size >= COMPARED_MAX - 1);
  }

  #scrollToOpen() {
    const row = this.#rows.get(this.#open);
    if (row?.isConnected) {
      const list = byId("pool-list");
      const head = list.querySelector("thead").offsetHeight;
      list.scrollTop = Math.min(Math.max(list.scrollTop, row.offsetTop + row.offsetHeight - list.clientHeight), row.offsetTop - head);
    }
  }

  #compare(name, isCompared) {
    if (this.#compared.has(name) === isCompared) {
      return;
    }
    if (isCompared) {
      this.#compared.add(name);
    } else {
      this.#compared.delete(name);
    }
    this.#pools.filter((pool) => this.#rows.has(pool.name)).forEach((pool) => this.#drawRow(pool));
    writeComparedPools([...this.#compared]);
    this.#onCompare([...this.#compared]);
  }
}
