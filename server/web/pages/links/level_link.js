// Checks links to levels: a link to what does not exist is reported, not replaced by another level.

import { byId, element } from "../elements/elements.js";

export const LEVEL_MAX = 2147483646;

// The problems of a query, whose parameters `own` are no options: { text, name: of the parameter, values: that are offered in its place,
// null: without it }. None if it is valid.
function problemsOf(catalog, query, own) {
  const named = (list, name) => list.find((each) => each.name === name);
  const [gameName, modeName] = [query.get("game") ?? "coinrun", query.get("mode") ?? "easy"];
  const game = named(catalog.games, gameName);
  if (!game) {
    return [{ text: `There is no game “${gameName}”.`, name: "game", values: catalog.games.map(({ name }) => name) }];
  }
  const mode = named(game.modes, modeName);
  if (!mode) {
    return [{ text: `${gameName} has no mode “${modeName}”.`, name: "mode", values: game.modes.map(({ name }) => name) }];
  }
  const problems = [];
  const { levelSeed: only } = mode;
  const level = query.get("level") ?? String(only ?? 0);
  if (only !== undefined && level !== String(only)) {
    problems.push({ text: `${gameName}, ${modeName} has no level “${level}”, only level ${only}.`, name: "level", values: [only] });
  } else if (!/^\d{1,10}$/.test(level) || Number(level) > LEVEL_MAX) {
    problems.push({ text: `There is no level “${level}”: levels are 0 to ${LEVEL_MAX}.`, name: "level", values: [0] });
  }
  for (const [name, value] of query) {
    const option = named(catalog.options, name);
    if (!option && !["game", "mode", "level", ...own].includes(name)) {
      problems.push({ text: `There is no option “${name}”.`, name, values: [null] });
    } else if (option && !isAllowed(option, value, game)) {
      problems.push({ text: `The option ${name} is “${value}”, allowed: ${allowedValues(option, game)}.`, name, values: [null] });
    }
  }
  return problems;
}

function allowedValues({ type, min, max }, { name, variants }) {
  return type === "boolean" ? "true or false"
    : type === "name" ? variants.join(", ") || `none in ${name}`
    : `integers from ${min} to ${max}`;
}

function isAllowed({ type, min, max }, value, { variants }) {
  return type === "boolean" ? ["true", "false"].includes(value)
    : type === "name" ? variants.some((each) => each.split("=")[0] === value.split("=")[0])
    : /^-?\d+$/.test(value) && value >= min && value <= max;
}

// A link to the page with another value of a parameter.
function offerOf(query, name, value) {
  const other = new URLSearchParams(query);
  other.delete(name);
  if (value !== null) {
    other.set(name, value);
  }
  const text = value === null ? `Without ${name}` : name === "level" ? `Level ${value}` : value;
  return element("li", {}, element("a", { href: `${location.pathname}?${other}` }, text));
}

// Shows the problems of the page's link in #wrong. `own`: parameters that are no options. Returns whether there are any.
export function showLinkProblems(catalog, own = []) {
  const query = new URLSearchParams(location.search);
  const problems = problemsOf(catalog, query, own);
  byId("wrong").hidden = problems.length === 0;
  byId("wrong").replaceChildren(element("h2", {}, "No such level"), ...problems.flatMap(({ text, name, values }) => [
    element("p", {}, text),
    element("ul", { class: "offers" }, ...values.map((value) => offerOf(query, name, value))),
  ]));
  return problems.length > 0;
}
