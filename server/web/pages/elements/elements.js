// DOM elements of the page.

// element("button", { class: "main", disabled: true, onclick: begin }, "Play") creates <button class="main" ...>Play</button>.
// Functions become listeners, booleans become properties, null and undefined are skipped, and other values become attributes.
// Children are elements or texts; texts are not parsed as HTML.
/** @returns {any} */
export function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (typeof value === "function") {
      made.addEventListener(key.replace(/^on/, ""), value);
    } else if (typeof value === "boolean") {
      made[key] = value;
    } else if (value !== null && value !== undefined) {
      made.setAttribute(key, value);
    }
  }
  made.append(...children.filter((child) => child !== null && child !== undefined));
  return made;
}

/**
 * The element with this id.
 * @returns {any}
 */
export function byId(id) {
  return document.getElementById(id);
}

// Sets a text if it differs, to avoid needless layout and screen reader output.
export function setText(target, text) {
  if (target.textContent !== text) {
    target.textContent = text;
  }
}

// Fills a <dl class="tiles"> with names and texts; an optional third text explains the name.
export function setTiles(list, tiles) {
  if (list.childElementCount !== tiles.length) {
    list.replaceChildren(...tiles.map(() => element("div", {}, element("dt"), element("dd"))));
  }
  tiles.forEach(([name, text, explanation = ""], index) => {
    const [term, value] = list.children[index].children;
    setText(term, name);
    term.title = explanation;
    setText(value, text);
  });
}

// Fills a <select>. `options`: pairs of a value and a text. The selection is kept if it is still offered.
export function setOptions(select, options, selected = select.value) {
  select.replaceChildren(...options.map(([value, text]) => element("option", { value }, text)));
  if (options.some(([value]) => value === selected)) {
    select.value = selected;
  }
}
