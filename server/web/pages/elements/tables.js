// Tables whose rows are sorted by a column that the user chooses.

import { element } from "./elements.js";

// Natural order: pools/2 before pools/10.
const collator = new Intl.Collator("en", { numeric: true });

// The header of a sorted table.
export class SortedHeader {
  #cells;
  #chosen;
  #isDescending;

  // `columns`: { title, isNumber?, value?(item) }; those without `value` cannot be sorted. `chosen`: the title of the first one.
  // `onChange()` is called when the user chooses another order.
  constructor(row, columns, chosen, isDescending, onChange) {
    this.#chosen = columns.find(({ title }) => title === chosen);
    this.#isDescending = isDescending;
    this.#cells = new Map(columns.map((column) => [column, this.#makeCell(column, onChange)]));
    row.replaceChildren(...this.#cells.values());
    this.#mark();
  }

  // A sorted copy; missing values (null) come last.
  sort(items) {
    const { value } = this.#chosen;
    const sign = this.#isDescending ? -1 : 1;
    return [...items].sort((one, other) => {
      const [a, b] = [value(one) ?? null, value(other) ?? null];
      if (a === null || b === null) {
        return Number(a === null) - Number(b === null);
      }
      return sign * (typeof a === "string" ? collator.compare(a, b) : a - b);
    });
  }

  #makeCell(column, onChange) {
    const { title, isNumber = false, value } = column;
    const choose = () => {
      // Numbers are sorted from the largest first.
      this.#isDescending = this.#chosen === column ? !this.#isDescending : isNumber;
      this.#chosen = column;
      this.#mark();
      onChange();
    };
    const content = value ? element("button", { type: "button", onclick: choose }, title) : element("span", {}, title);
    return element("th", { scope: "col", class: isNumber ? "number" : null }, content);
  }

  #mark() {
    this.#cells.forEach((cell, column) => {
      if (column === this.#chosen) {
        cell.setAttribute("aria-sort", this.#isDescending ? "descending" : "ascending");
      } else {
        cell.removeAttribute("aria-sort");
      }
    });
  }
}
