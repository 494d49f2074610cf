// The token that a server asks for. It is kept for this tab alone, and never put into an address.

import { element } from "./elements.js";

const KEY = "token";

export function savedToken() {
  return sessionStorage.getItem(KEY);
}

export function forgetToken() {
  sessionStorage.removeItem(KEY);
}

// Asks the person for the token until there is one. `problem`: why the one before was refused, or "".
export function askToken(problem) {
  return new Promise((resolve) => {
    const input = element("input", {
      type: "password", id: "token", name: "token", autocomplete: "current-password", required: true, spellcheck: "false",
      "aria-describedby": "token-problem",
    });
    const form = element("form", { class: "token", method: "dialog" },
      element("h2", { id: "token-title" }, "This server asks who you are"),
      element("p", { class: "quiet" }, "Give the token that whoever runs it gave you. This tab keeps it until it is closed."),
      element("label", { class: "field" }, "Token", input),
      element("p", { class: "problem", id: "token-problem", role: "alert" }, problem),
      element("div", { class: "row" }, element("button", { class: "main", type: "submit" }, "Go on")));
    const dialog = element("dialog", { "aria-labelledby": "token-title" }, form);
    dialog.addEventListener("cancel", (event) => event.preventDefault());
    // A browser closes it all the same for who insists; there is nothing to see without a token.
    dialog.addEventListener("close", () => dialog.isConnected && dialog.showModal());
    form.addEventListener("submit", () => {
      sessionStorage.setItem(KEY, input.value.trim());
      dialog.remove();
      resolve(savedToken());
    });
    document.body.append(dialog);
    dialog.showModal();
  });
}
