// Notices below the top bar, which can be dismissed.

import { element } from "./elements.js";

const SHOWN_MS = 6000;
const COUNT_MAX = 3;

const list = element("div", { class: "notices", id: "notices", role: "status", "aria-live": "polite" });
document.body.append(list);

// Adds a notice. `kind`: "", "warn" or "bad". It disappears after a while, except if it is bad.
export function notify(text, kind = "") {
  raise();
  const notice = element("div", { class: `notice ${kind}` }, element("p", {}, text));
  notice.append(element("button", { type: "button", "aria-label": "Dismiss", onclick: () => notice.remove() }, "✕"));
  list.append(notice);
  while (list.childElementCount > COUNT_MAX) {
    list.firstChild.remove();
  }
  if (kind !== "bad") {
    setTimeout(() => notice.remove(), SHOWN_MS);
  }
}

export function clearNotices() {
  list.replaceChildren();
}

// A message of the server as a sentence.
export function sentence(text) {
  return text.charAt(0).toUpperCase() + text.slice(1) + (/[.!?]$/.test(text) ? "" : ".");
}

// Elements outside of a modal dialog are behind it and cannot be used, so notices are in the dialog while one is open.
function raise() {
  const dialog = [...document.querySelectorAll("dialog[open]")].at(-1);
  (dialog ?? document.body).append(list);
  dialog?.addEventListener("close", () => document.body.append(list), { once: true });
}
