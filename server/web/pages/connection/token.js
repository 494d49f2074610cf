// The access token. It is kept for this tab only, and never put into a URL.

import { element } from "../elements/elements.js";

const KEY = "token";

export function savedToken() {
  return sessionStorage.getItem(KEY);
}

export function forgetToken() {
  sessionStorage.removeItem(KEY);
}

// Prompts for the token until one is entered. `problem`: why the previous one was rejected, or "".
export function askToken(problem) {
  return new Promise((resolve) => {
    const input = element("input", {
      type: "password", id: "token", name: "token", autocomplete: "current-password", required: true, spellcheck: "false",
      "aria-describedby": "token-problem",
    });
    const form = element("form", { class: "token", method: "dialog" },
      element("h2", { id: "token-title" }, "This server requires a token"),
      element("p", { class: "quiet" }, "Enter the token that you got from the operator. It is kept until this tab is closed."),
      element("label", { class: "field" }, "Token", input),
      element("p", { class: "problem", id: "token-problem", role: "alert" }, problem),
      element("div", { class: "row" }, element("button", { class: "main", type: "submit" }, "Continue")));
    const dialog = element("dialog", { "aria-labelledby": "token-title" }, form);
    dialog.addEventListener("cancel", (event) => event.preventDefault());
    // Browsers let users close the dialog anyway; without a token the page is empty.
    dialog.addEventListener("close", () => dialog.isConnected && dialog.showModal());
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      sessionStorage.setItem(KEY, input.value.trim());
      dialog.remove();
      resolve(savedToken());
    });
    document.body.append(dialog);
    dialog.showModal();
  });
}
