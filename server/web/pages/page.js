// Shared by all pages: the top bar, the connection and its state, the theme, notices and the token prompt.

import { Connection, LOST } from "./connection.js";
import { byId, element, setText } from "./elements.js";
import { askToken, forgetToken, savedToken } from "./token.js";

const PAGES = [["/", "Live"], ["/play", "Play"], ["/replay", "Replay"], ["/gallery", "Gallery"]];
const NOTICE_MS = 6000;

// Shows the page and connects. `onReady(hello, connection)` is called when the server accepts the page, and again after each
// reconnect. Returns the connection.
export function openPage(onReady, onLost = () => {}) {
  const state = element("span", { class: "link", role: "status", "data-state": "connecting" }, "Connecting");
  drawBar(state);
  const connection = new Connection();
  let wasLost = false;
  connection.addEventListener("open", async () => {
    const hello = await greet(connection);
    if (!hello) {
      return;
    }
    state.dataset.state = "open";
    setText(state, "Connected");
    if (wasLost) {
      notify("Reconnected to the server.");
    }
    wasLost = false;
    onReady(hello, connection);
  });
  connection.addEventListener("lost", ({ detail }) => {
    state.dataset.state = "lost";
    setText(state, "Waiting for the server");
    if (!wasLost) {
      notify(detail || "The connection to the server was lost. Reconnecting.", "warn");
      onLost();
    }
    wasLost = true;
  });
  connection.open();
  return connection;
}

// Sends hello. Returns the answer, or null if the server rejects the page; then it is retried, with another token if
// necessary.
async function greet(connection) {
  const token = savedToken();
  try {
    return await connection.call("hello", token ? { token } : {});
  } catch (error) {
    if (error.code === "UNAUTHENTICATED") {
      // The server's time limit for hello is shorter than a person's search for a token.
      connection.close();
      forgetToken();
      await askToken(token ? "The server does not know this token. Is it complete?" : "");
      connection.open();
    } else {
      tell(error);
    }
    return null;
  }
}

function drawBar(state) {
  const links = PAGES.map(([path, name]) =>
    element("a", { href: path, "aria-current": path === location.pathname ? "page" : null }, name));
  byId("top").replaceChildren(
    element("a", { class: "mark", href: "/" }, mark(), "Procgen Server"),
    element("nav", { "aria-label": "Pages" }, ...links),
    element("div", { class: "end" }, state, themeButton()));
  document.body.append(element("div", { class: "notices", id: "notices", role: "status", "aria-live": "polite" }));
}

// The logo: four cells, one of them raised.
function mark() {
  const drawing = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  drawing.setAttribute("viewBox", "0 0 12 12");
  drawing.setAttribute("aria-hidden", "true");
  const cells = document.createElementNS("http://www.w3.org/2000/svg", "path");
  cells.setAttribute("d", "M0 7h5v5H0zM7 7h5v5H7zM0 0h5v5H0zM8 1h3v3H8z");
  drawing.append(cells);
  return drawing;
}

function isDark() {
  const chosen = document.documentElement.dataset.theme;
  return chosen ? chosen === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
}

function themeButton() {
  const button = element("button", { type: "button", onclick: () => {
    const theme = isDark() ? "light" : "dark";
    document.documentElement.dataset.theme = theme;
    localStorage.setItem("theme", theme);
    show();
    document.dispatchEvent(new Event("theme"));
  } });
  const show = () => setText(button, isDark() ? "Light theme" : "Dark theme");
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    show();
    document.dispatchEvent(new Event("theme"));
  });
  show();
  return button;
}

// Shows a notice at the foot of the page for a while. `kind`: "", "warn" or "bad".
export function notify(text, kind = "") {
  const notice = element("p", { class: `notice ${kind}` }, text);
  byId("notices").replaceChildren(notice);
  setTimeout(() => notice.remove(), NOTICE_MS);
}

// Runs an action of the user and shows its error. Returns its result, or null.
export async function attempt(work) {
  try {
    return await work();
  } catch (error) {
    if (error.name !== "ServerError") {
      throw error;
    }
    tell(error);
    return null;
  }
}

// The page reports a lost connection once.
function tell(error) {
  if (error.code !== LOST) {
    notify(error.message, "bad");
  }
}
