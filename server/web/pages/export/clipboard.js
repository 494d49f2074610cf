// Copies texts to the clipboard.

import { element } from "../elements/elements.js";
import { notify } from "../elements/notices.js";

// Copies a text. Where the browser does not allow that (without HTTPS), a dialog shows the text, selected.
export async function copy(text, what) {
  try {
    await navigator.clipboard.writeText(text);
    notify(`Copied ${what}.`);
  } catch {
    show(text, what);
  }
}

function show(text, what) {
  const field = element("textarea", { readonly: "", rows: 12, spellcheck: "false", "aria-label": what });
  field.value = text;
  const dialog = element("dialog", { class: "copied", "aria-label": `Copy ${what}`, onclose: () => dialog.remove() },
    element("p", {}, `The browser does not let this page copy. Copy ${what} here:`), field,
    element("button", { type: "button", onclick: () => dialog.close() }, "Close"));
  document.body.append(dialog);
  dialog.showModal();
  field.select();
}
