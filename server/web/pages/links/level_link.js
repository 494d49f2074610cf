// Checks links to levels: a link to what does not exist is reported, not replaced by another level.

import { byId, element } from "../elements/elements.js";
import { addressOf } from "./level_choice.js";

export const LEVEL_MAX = 2147483646;

// The problems of a query for a page at `path`, whose own parameters are `own`: for each a text, and offers [[text, address], ...]. None if it is valid.
function problemsOf(catalog, query, path, own) {
  const game = query.get("game") ?? "coinrun";
  const facts = catalog.games.find(({ name }) => name === game);
  const withOther = (changes) => {
    const other = new URLSearchParams(query);
    Object.entries(changes).forEach(([name, value]) => (value === null ? other.delete(name) : other.set(name, value)));
    return `${path}?${other}`;
  };
  if (!facts) {
    return [{
      text: `There is no game “${game}”.`,
      offers: catalog.games.map(({ name, modes }) => [name, addressOf(path, levelOf(name, modes[0]))]),
    }];
  }
  const mode = query.get("mode") ?? "easy";
  const found = facts.modes.find(({ name }) => name === mode);
  if (!found) {
    return [{
      text: `${game} has no mode “${mode}”.`,
      offers: facts.modes.map((one) => [one.name, withOther({ mode: one.name, ...(one.levelSeed === undefined ? {} : { level: one.levelSeed }) })]),
    }];
  }
  const problems = [];
  const level = query.get("level") ?? String(found.levelSeed ?? 0);
  if (found.levelSeed !== undefined && level !== String(found.levelSeed)) {
    problems.push({
      text: `${game}, ${mode} has no level “${level}”, only level ${found.levelSeed}.`,
      offers: [[`Level ${found.levelSeed}`, withOther({ level: found.levelSeed })]],
    });
  } else if (!/^\d{1,10}$/.test(level) || Number(level) > LEVEL_MAX) {
    problems.push({ text: `There is no level “${level}”: levels are 0 to ${LEVEL_MAX}.`, offers: [["Level 0", withOther({ level: 0 })]] });
  }
  for (const [name, value] of query) {
    if (["game", "mode", "level", ...own].includes(name)) {
      continue;
    }
    const option = catalog.options.find((one) => one.name === name);
    const allowed = option && allowedOf(option);
    if (!option || !isAllowed(option, value)) {
      problems.push({
        text: option ? `The option ${name} is “${value}”, allowed: ${allowed}.` : `There is no option “${name}”.`,
        offers: [[`Without ${name}`, withOther({ [name]: null })]],
      });
    }
  }
  return problems;
}

function levelOf(game, mode) {
  return { game, mode: mode.name, level: mode.levelSeed ?? 0 };
}

function allowedOf({ type, min, max }) {
  return type === "boolean" ? "true or false" : `integers from ${min} to ${max}`;
}

function isAllowed({ type, min, max }, value) {
  return type === "boolean" ? ["true", "false"].includes(value) : /^-?\d+$/.test(value) && value >= min && value <= max;
}

// Shows the problems of the page's link in #wrong. `own`: parameters that are no options. Returns whether there are any.
export function showLinkProblems(catalog, own = []) {
  const problems = problemsOf(catalog, new URLSearchParams(location.search), location.pathname, own);
  const place = byId("wrong");
  place.hidden = problems.length === 0;
  place.replaceChildren(element("h2", {}, "No such level"), ...problems.flatMap(({ text, offers }) => [
    element("p", {}, text),
    element("ul", { class: "offers" }, ...offers.map(([name, href]) => element("li", {}, element("a", { href }, name)))),
  ]));
  return problems.length > 0;
}
