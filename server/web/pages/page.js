// Shared by all pages: the top bar, the connection and its state, and the token prompt.

import { catalogOf } from "./connection/catalog.js";
import { Connection } from "./connection/connection.js";
import { LOST, UserError } from "./connection/errors.js";
import { askToken, forgetToken, savedToken } from "./connection/token.js";
import { byId, element, setText } from "./elements/elements.js";
import { clock } from "./elements/figures.js";
import { notify, sentence } from "./elements/notices.js";

const PAGES = [["/", "Live"], ["/play", "Play"], ["/replay", "Replay"], ["/gallery", "Gallery"]];
// Close code of the WebSocket: the server has as many pages as it takes.
const TRY_AGAIN_LATER = 1013;

let page = null;  // { connection, state, onLost, hasContent, isOut, isLost, isAsking }

// Shows the page and connects. `onReady(hello, connection)` is called when the server accepts the page, and again after each
// reconnect; `onLost()` when the connection is lost or given up; `onSilent()` when the server sends nothing for some time.
// hello: { catalog, requiresToken, address: of the server, for programs }.
export async function openPage(onReady, onLost = () => {}, onSilent = () => {}) {
  const state = element("span", { class: "link", role: "status", "data-state": "connecting" }, "Connecting");
  drawBar(state);
  const connection = await Connection.load();
  const { bridge } = connection;
  page = { connection, state, onLost, hasContent: false, isOut: false, isLost: false, isAsking: false };
  bridge.on("open", async () => {
    const hello = await greet();
    if (!hello) {
      return;
    }
    if (page.isOut) {
      notify("Reconnected to the server.");
    }
    page.hasContent = true;
    page.isLost = false;
    endOutage();
    onReady(hello, connection);
  });
  bridge.on("lost", (loss) => {
    if (!page.isLost && page.hasContent) {
      onLost();
    }
    page.isLost = true;
    beginOutage(describeLoss(loss), loss.code === TRY_AGAIN_LATER ? "Server is full" : "Waiting for the server");
  });
  bridge.on("silent", ({ timeS }) => {
    beginOutage(`The server has sent nothing since ${clock(timeS)}.`, "No answer");
    onSilent();
  });
  bridge.on("heard", endOutage);
  bridge.open();
}

function describeLoss({ code, reason }) {
  if (code === TRY_AGAIN_LATER) {
    return `${sentence(reason)} This page opens when another is closed.`;
  }
  const cause = reason ? sentence(reason).slice(0, -1) : "The connection was lost";
  return `${cause} at ${clock(Date.now() / 1000)}. Trying to reconnect.`;
}

// Marks all content as outdated, for the reason in `text`, until endOutage.
function beginOutage(text, stateText) {
  page.state.dataset.state = "lost";
  if (!page.isOut || page.state.textContent !== stateText) {
    setText(byId("outage"), page.hasContent ? `${text} What is shown is older.` : text);
  }
  setText(page.state, stateText);
  page.isOut = true;
  byId("outage").hidden = false;
  document.documentElement.toggleAttribute("data-outdated", page.hasContent);
}

function endOutage() {
  page.isOut = false;
  page.state.dataset.state = "open";
  setText(page.state, "Connected");
  byId("outage").hidden = true;
  document.documentElement.removeAttribute("data-outdated");
}

// Introduces the page. Returns what onReady gets, or null if the server rejects the page; then it is retried, with another token if
// necessary.
async function greet() {
  const { connection } = page;
  const token = savedToken();
  try {
    if (token) {
      connection.bridge.sendToken(token);
    }
    const [catalog, { cluster, localNode, nodes }] = await Promise.all(
      [connection.call("CatalogService.GetCatalog"), connection.call("ClusterService.ListNodes")]);
    const { address = "" } = nodes.find(({ name }) => name === localNode) ?? {};
    // The browser's host name if the server listens on all addresses.
    const reachable = address.replace(/^(0\.0\.0\.0|\[::\]):/, `${location.hostname}:`);
    return { catalog: catalogOf(catalog), requiresToken: token !== null, cluster, address: reachable };
  } catch (error) {
    if (error.code === "UNAUTHENTICATED") {
      changeToken(token ? "The server does not know this token. Is it complete?" : "");
    } else {
      tell(error);
    }
    return null;
  }
}

// Asks for a token and connects with it. Meanwhile the page is not connected: the server's time limit for the first answer is
// shorter than a person's search for a token.
async function changeToken(problem = "The server no longer accepts this token.") {
  if (page.isAsking) {
    return;
  }
  page.isAsking = true;
  page.connection.bridge.close();
  if (page.hasContent) {
    page.onLost();
  }
  forgetToken();
  await askToken(problem);
  page.isAsking = false;
  page.connection.bridge.open();
}

function drawBar(state) {
  const links = PAGES.map(([path, name]) =>
    element("a", { href: path, "aria-current": path === location.pathname ? "page" : null }, name));
  byId("top").replaceChildren(
    element("a", { class: "mark", href: "/" }, element("img", { src: "/assets/icon.svg", alt: "" }), "Procgen Server"),
    element("nav", { "aria-label": "Pages" }, ...links),
    element("div", { class: "end" }, state));
  byId("top").after(element("p", { class: "outage", id: "outage", role: "alert", hidden: true }));
}

// Runs an action of the user and shows its error with `say`. Returns its result, or null.
export async function attempt(work, say = (text) => notify(text, "bad")) {
  try {
    return await work();
  } catch (error) {
    if (!(error instanceof UserError)) {
      throw error;
    }
    tell(error, say);
    return null;
  }
}

// Reports that the pools are not listed any more. A token that was removed is asked for again.
export function loseReports(error) {
  if (error.code === "UNAUTHENTICATED") {
    changeToken();
  } else if (error.code !== LOST) {
    beginOutage(`${sentence(error.message)} The pools are no longer reported.`, "No reports");
  }
}

// Ends the outage of loseReports.
export function regainReports() {
  if (page.isOut) {
    endOutage();
  }
}

// The page reports a lost connection once.
function tell(error, say = (text) => notify(text, "bad")) {
  if (error.code === "UNAUTHENTICATED") {
    changeToken();
  } else if (error.code !== LOST) {
    say(sentence(error.message));
  }
}
