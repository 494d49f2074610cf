// The settings of the plots in the URL, if they differ from their defaults.

import { byId } from "../elements/elements.js";

const CONTROLS = ["span", "x", "smoothing", "normalised"];
const COMPARE = "compare";

function valueOf(control) {
  return control.type === "checkbox" ? String(control.checked) : control.value;
}

function defaultOf(control) {
  return control.type === "checkbox" ? "false" : (control.querySelector("[selected]") ?? control.options[0]).value;
}

// Sets the controls from the URL, and the URL from the controls when they change. Values that are not offered are ignored.
export function keepSettings() {
  const query = new URLSearchParams(location.search);
  for (const name of CONTROLS) {
    const control = byId(name);
    const wanted = query.get(name);
    if (control.type === "checkbox") {
      control.checked = wanted === "true";
    } else if ([...control.options].some(({ value }) => value === wanted)) {
      control.value = wanted;
    }
    control.addEventListener("change", () => write(name, valueOf(control) === defaultOf(control) ? null : valueOf(control)));
  }
}

// The names of the pools in the URL that are compared with the open one.
export function comparedPools() {
  return new URLSearchParams(location.search).getAll(COMPARE);
}

export function writeComparedPools(names) {
  write(COMPARE, ...(names.length === 0 ? [null] : names));
}

// The URL that shows another pool with the same settings.
export function addressOfPool(name) {
  const query = new URLSearchParams(location.search);
  query.delete("environment");
  query.set("pool", name);
  return `/?${query}`;
}

// Sets a parameter of the URL to some values; null: removes it.
function write(name, ...values) {
  const url = new URL(location.href);
  url.searchParams.delete(name);
  values.filter((value) => value !== null).forEach((value) => url.searchParams.append(name, value));
  history.replaceState(null, "", url);
}
