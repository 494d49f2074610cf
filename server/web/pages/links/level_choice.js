// A level (game, mode, seed and options) in a form, a URL and a request.

import { element, setOptions } from "../elements/elements.js";

// Shows the options below `place`, as check boxes and fields named after them. drawGames fills the choice of a variant.
export function drawOptions(place, catalog) {
  place.replaceChildren(...catalog.options.map((option) => {
    const name = option.name;
    if (option.type === "boolean") {
      const box = element("input", { type: "checkbox", name, checked: option.default });
      return element("label", { class: "check", title: option.description }, box, title(name));
    }
    if (option.type === "name") {
      return element("label", { class: "field", title: option.description }, title(name), element("select", { name }));
    }
    const { min, max } = option;
    const number = element("input", { type: "number", name, min, max, step: 1, value: option.default });
    return element("label", { class: "field", title: option.description }, title(name), number);
  }));
}

// The texts of those `options` that differ from their defaults, e.g. ["use backgrounds false"].
export function tellOptions(options, catalog) {
  return catalog.options.filter(({ name, default: usual }) => (options[name] ?? usual) !== usual)
    .map(({ name }) => `${title(name)} ${options[name]}`);
}

// use_backgrounds -> "use backgrounds", for display.
function title(name) {
  return name.replaceAll("_", " ");
}

// The options of a form that differ from their defaults: true, false, a number or a text by name.
export function optionsOf(form, catalog) {
  const chosen = {};
  for (const { name, type, default: usual } of catalog.options) {
    const input = form.elements[name];
    const value = type === "boolean" ? input.checked : type === "name" ? input.value : input.valueAsNumber;
    if (value !== usual && !Number.isNaN(value)) {
      chosen[name] = value;
    }
  }
  return chosen;
}

// Fills the choice of games, of modes and variants of the selected game, and the level of a mode with a single level.
export function drawGames(form, catalog) {
  const { game, mode, level, variant } = form.elements;
  const selected = () => catalog.games.find(({ name }) => name === game.value);
  const modes = () => selected().modes;
  const drawLevel = () => {
    const only = modes().find(({ name }) => name === mode.value).levelSeed;
    level.readOnly = only !== undefined;
    level.value = only ?? level.value;
  };
  const drawModes = () => {
    setOptions(mode, modes().map(({ name }) => [name, name]), mode.value || "easy");
    setOptions(variant, [["", "none"], ...selected().variants.map((name) => [name, name])]);
    drawLevel();
  };
  game.addEventListener("change", drawModes);
  mode.addEventListener("change", drawLevel);
  setOptions(game, catalog.games.map(({ name }) => [name, name]), game.value || "coinrun");
  drawModes();
}

// Sets a form from a URL query (or another list of names and texts); values that the form does not offer are ignored.
export function readAddress(form, parameters) {
  for (const name of ["game", "mode", "level"]) {
    const input = form.elements[name];
    if (input && parameters.has(name)) {
      setIfOffered(input, parameters.get(name));
    }
  }
  for (const input of form.querySelectorAll("#options input, #options select")) {
    if (!parameters.has(input.name)) {
      continue;
    }
    if (input.type === "checkbox") {
      input.checked = parameters.get(input.name) === "true";
    } else {
      setIfOffered(input, parameters.get(input.name));
    }
  }
}

function setIfOffered(input, text) {
  const before = input.value;
  input.value = text;
  if (!input.checkValidity() || input.value === "") {
    input.value = before;
  }
  input.dispatchEvent(new Event("change"));
}

// The URL of a page that shows this level.
export function addressOf(path, { game, mode, level, options = {} }) {
  return `${path}?${new URLSearchParams({ game, mode, level, ...options })}`;
}
