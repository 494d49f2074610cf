// The table of pools: filter, order and comparison.

import { byId, element, setText } from "../elements/elements.js";
import { count, duration, plural, rate, reward } from "../elements/figures.js";
import { drawSparkline, makeSparkline } from "../elements/sparkline.js";
import { SortedHeader } from "../elements/tables.js";
import { attempt } from "../page.js";

const COMPARED_MAX = 8;
const RETURNS_INTERVAL_MS = 10_000;
const IDLE_S = 5;  // without a step

const COLUMNS = [
  { title: "Pool", value: ({ name }) => name },
  { title: "State", value: ({ state }) => state.rank },
  { title: "Game", value: (pool) => gamesOf(pool) },
  { title: "Mode", value: ({ mode }) => mode },
  { title: "Environments", isNumber: true, value: ({ env_count: number }) => number },
  { title: "Steps / s", isNumber: true, value: ({ steps_per_second: number }) => number },
  { title: "Return", isNumber: true, value: ({ mean_return: number }) => number },
  { title: "Last hour" },
  { title: "Episodes", isNumber: true, value: ({ episode_count: number }) => number },
  { title: "Age", isNumber: true, value: ({ age_s: age }) => age },
  { title: "Compare" },
];

export function gamesOf({ games }) {
  const names = [...new Set(games)];
  return names.length > 3 ? `${names.length} games` : names.join(", ");
}

// The state of a pool at `time`: a text, the class of its badge, and its place in the order. `isUnknown`: the connection broke.
export function stateOf({ isUnknown, paused, last_step_time_s: stepped }, time) {
  if (isUnknown) {
    return { text: "unknown", kind: "warn", rank: 3 };
  }
  if (paused) {
    return { text: "paused", kind: "warn", rank: 1 };
  }
  if (stepped === null) {
    return { text: "never stepped", kind: "", rank: 2 };
  }
  const idle = time - stepped;
  return idle > IDLE_S ? { text: `idle for ${duration(idle)}`, kind: "warn", rank: 1 } : { text: "running", kind: "on", rank: 0 };
}

export class PoolTable {
  #connection = null;
  #pools = [];
  #open = null;          // name
  #rows = new Map();     // name -> row
  #returns = new Map();  // name -> mean returns of the last hour
  #returnsTime = -RETURNS_INTERVAL_MS;
  #compared = new Set();  // names, without the open pool
  #header = new SortedHeader(byId("pool-columns"), COLUMNS, "State", false, () => this.#arrange());
  #onOpen;
  #onCompare;

  // `onOpen(event)`: a pool's link was clicked; `onCompare(names)`: others are compared with the open pool.
  constructor(onOpen, onCompare) {
    this.#onOpen = onOpen;
    this.#onCompare = onCompare;
    byId("pool-filter").addEventListener("input", () => this.#arrange());
  }

  // Shows the pools of an event at `time`; `open` is the name of the open one.
  draw(connection, pools, time, open) {
    this.#connection = connection;
    this.#pools = pools.map((pool) => ({
      ...pool,
      age_s: time - pool.create_time_s,
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
    this.#requestReturns();
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
      const text = [pool.name, ...pool.games, pool.mode, pool.owner, pool.state.text].join(" ").toLowerCase();
      return words.every((word) => text.includes(word));
    }).map(({ name }) => this.#rows.get(name));
    const list = byId("pools");
    if (shown.length !== list.childElementCount || shown.some((row, index) => list.children[index] !== row)) {
      const focused = list.contains(document.activeElement) ? document.activeElement : null;
      list.replaceChildren(...shown);
      focused?.focus({ preventScroll: true });
    }
    setText(byId("pools-none"), this.#pools.length > 0 && shown.length === 0 ? "No pool matches the filter." : "");
    setText(byId("pools-count"), shown.length === this.#pools.length ? plural(shown.length, "pool")
      : `${count(shown.length)} of ${plural(this.#pools.length, "pool")}`);
  }

  #makeRow({ name }) {
    const compare = element("input", {
      type: "checkbox", "aria-label": `Compare ${name}`, onchange: ({ target }) => this.#compare(name, target.checked),
    });
    const cells = COLUMNS.map(({ isNumber, title }) => element("td", { class: isNumber ? "number" : null }, {
      Pool: element("a", { href: `/?pool=${encodeURIComponent(name)}`, onclick: this.#onOpen }, name),
      State: element("span"), "Last hour": makeSparkline(), Compare: compare,
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
    setText(cell("Game"), gamesOf(pool));
    cell("Game").title = pool.games.join(", ");
    setText(cell("Mode"), pool.mode);
    setText(cell("Environments"), count(pool.env_count));
    setText(cell("Steps / s"), rate(pool.steps_per_second));
    setText(cell("Return"), reward(pool.mean_return));
    setText(cell("Episodes"), rate(pool.episode_count));
    setText(cell("Age"), duration(pool.age_s));
    const isOpen = pool.name === this.#open;
    row.classList.toggle("open", isOpen);
    const link = cell("Pool").firstChild;
    link.title = pool.owner ? `owner ${pool.owner}` : "";
    if (isOpen) {
      link.setAttribute("aria-current", "true");
    } else {
      link.removeAttribute("aria-current");
    }
    const box = cell("Compare").firstChild;
    box.checked = isOpen || this.#compared.has(pool.name);
    box.disabled = isOpen || (!box.checked && this.#compared.size >= COMPARED_MAX - 1);
    const returns = this.#returns.get(pool.name) ?? [];
    drawSparkline(cell("Last hour").firstChild, returns, returns.length === 0 ? "No returns yet"
      : `Mean return from ${reward(returns.find((value) => value !== null))} to ${reward(returns.at(-1))}`);
  }

  #scrollToOpen() {
    const row = this.#rows.get(this.#open);
    if (row?.isConnected) {
      const list = byId("pool-list");
      const head = list.querySelector("thead").offsetHeight;
      list.scrollTop = Math.min(Math.max(list.scrollTop, row.offsetTop + row.offsetHeight - list.clientHeight), row.offsetTop - head);
    }
  }

  async #requestReturns() {
    if (!this.#connection || document.hidden || performance.now() - this.#returnsTime < RETURNS_INTERVAL_MS) {
      return;
    }
    this.#returnsTime = performance.now();
    const answer = await attempt(() => this.#connection.call("pools.returns"), () => {});
    if (answer) {
      this.#returns = new Map(answer.pools.map(({ name, mean_returns: returns }) => [name, returns]));
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
    this.#onCompare([...this.#compared]);
  }
}
