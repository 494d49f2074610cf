// What every page does: the bar on top, the connection with its state, the theme, notices, and the token where one is asked.

import { Connection, LOST } from "./connection.js";
import { byId, element, setText } from "./elements.js";
import { askToken, forgetToken, savedToken } from "./token.js";

const PAGES = [["/", "Live"], ["/play", "Play"], ["/replay", "Replay"], ["/gallery", "Gallery"]];
const NOTICE_MS = 6000;

// Shows the page and connects. `onReady(hello, connection)` is called once the server has let the page in, and again each
// time after the connection was lost. Gives the connection.
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
      notify("The server is back.");
    }
    wasLost = false;
    onReady(hello, connection);
  });
  connection.addEventListener("lost", ({ detail }) => {
    state.dataset.state = "lost";
    setText(state, "Waiting for the server");
    if (!wasLost) {
      notify(detail || "The server is gone. The page goes on as soon as it is back.", "warn");
      onLost();
    }
    wasLost = true;
  });
  connection.open();
  return connection;
}

// Says hello. Gives the server's answer, or null if it does not let the page in: then it is tried again, if need be with
// another token.
async function greet(connection) {
  const token = savedToken();
  try {
    return await connection.call("hello", token ? { token } : {});
  } catch (error) {
    if (error.code === "UNAUTHENTICATED") {
      // A server does not wait for somebody who looks for a token.
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

// Four cells, one of them risen.
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

// Says something at the foot of the page for a while. `kind`: "", "warn" or "bad".
export function notify(text, kind = "") {
  const notice = element("p", { class: `notice ${kind}` }, text);
  byId("notices").replaceChildren(notice);
  setTimeout(() => notice.remove(), NOTICE_MS);
}

// Carries out what a person asked for, and says what went wrong. Gives its result, or null.
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

// That the connection is gone is said once, by the page.
function tell(error) {
  if (error.code !== LOST) {
    notify(error.message, "bad");
  }
}
