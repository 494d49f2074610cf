// The gallery: all games, or the levels of the game in the URL. Each image links to its level.

import { byId, element, setText } from "./elements/elements.js";
import { drawImage } from "./elements/pictures.js";
import { addressOf, drawGames, drawOptions, optionsOf, readAddress } from "./links/level_choice.js";
import { LEVEL_MAX, showLinkProblems } from "./links/level_link.js";
import { attempt, openPage } from "./page.js";
import { levelImages } from "./run/level_images.js";

const SAMPLE_COUNT = 4;     // levels of a game in the overview
const PAGE_COUNT = 24;      // levels of a page
const SIZE_PX = 256;

const parameters = new URLSearchParams(location.search);
let isDrawn = false;  // kept across reconnects

async function ready(hello, connection) {
  if (isDrawn) {
    return;
  }
  isDrawn = true;
  const { catalog } = hello;
  if (showLinkProblems(catalog, ["whole"])) {
    return;
  }
  if (parameters.has("game")) {
    drawForm(catalog);
    isDrawn = await drawLevels(connection, catalog);
  } else {
    isDrawn = await drawOverview(connection, catalog);
  }
}

async function drawOverview(connection, catalog) {
  byId("overview").hidden = false;
  const cards = catalog.games.map((game) => {
    const strip = element("div", { class: "strip" });
    const modes = game.modes.map(({ name, levelSeed: level = 0 }) =>
      element("li", {}, element("a", { href: addressOf("/gallery", { game: game.name, mode: name, level }) }, name)));
    const first = addressOf("/gallery", { game: game.name, mode: game.modes[0].name, level: 0 });
    const card = element("li", { class: "game panel" }, strip,
      element("h2", {}, element("a", { href: first }, game.name)),
      element("p", { class: "small quiet" }, game.description),
      element("ul", { class: "modes", "aria-label": `Modes of ${game.name}` }, ...modes));
    return { game, strip, card };
  });
  byId("games").replaceChildren(...cards.map(({ card }) => card));
  const drawn = await Promise.all(cards.map(async ({ game, strip }) => {
    const choice = { game: game.name, mode: game.modes[0].name, level: 0 };
    const pictures = await drawPage(connection, choice, false, SAMPLE_COUNT, () => null);
    strip.replaceChildren(...(pictures ?? []));
    return pictures !== null;
  }));
  return drawn.every(Boolean);
}

function drawForm(catalog) {
  const form = byId("choice");
  drawOptions(byId("options"), catalog);
  drawGames(form, catalog);
  readAddress(form, parameters);
  form.elements.whole.checked = parameters.get("whole") === "true";
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    location.assign(pageOf(choiceOf(form, catalog)));
  });
}

function choiceOf(form, catalog) {
  const { game, mode, level, whole } = form.elements;
  return {
    game: game.value, mode: mode.value, level: level.valueAsNumber, options: optionsOf(form, catalog), whole: whole.checked,
  };
}

// The URL of the levels from a choice on.
function pageOf(choice) {
  return addressOf("/gallery", choice) + (choice.whole ? "&whole=true" : "");
}

async function drawLevels(connection, catalog) {
  const choice = choiceOf(byId("choice"), catalog);
  const game = catalog.games.find(({ name }) => name === choice.game);
  const mode = game.modes.find(({ name }) => name === choice.mode);
  document.title = `${game.name}, ${mode.name} – Procgen Server`;
  byId("levels").hidden = false;
  setText(byId("title"), `${game.name}, ${mode.name}`);
  setText(byId("about"), game.description);
  const most = mode.levelSeed === undefined ? LEVEL_MAX - choice.level + 1 : 1;
  const caption = (seed) => element("span", { class: "small quiet" }, `Level ${seed}`);
  const pictures = await drawPage(connection, choice, mode.levelSeed !== undefined, Math.min(PAGE_COUNT, most), caption);
  byId("pictures").replaceChildren(...(pictures ?? []).map((picture) => element("li", {}, picture)));
  turnTo(byId("previous"), choice, choice.level > 0 && most > 1, -PAGE_COUNT);
  turnTo(byId("following"), choice, most > PAGE_COUNT, PAGE_COUNT);
  return pictures !== null;
}

function turnTo(link, choice, isThere, by) {
  link.hidden = !isThere;
  link.href = pageOf({ ...choice, level: Math.max(0, choice.level + by) });
}

// The levels of a gallery page, as links to play them; null if the request failed. `isOnly`: the mode has one level.
async function drawPage(connection, choice, isOnly, count, caption) {
  const { game, mode, options } = choice;
  const images = await attempt(() => levelImages(connection, choice, isOnly, count, SIZE_PX));
  return images && Promise.all(images.map(async ({ level, image }) => {
    const canvas = element("canvas");
    await drawImage(canvas, image);
    const address = addressOf("/play", { game, mode, level, options });
    return element("a", { href: address, "aria-label": `Play ${game}, level ${level}`, title: `Level ${level}` }, canvas, caption(level));
  }));
}

openPage(ready);
