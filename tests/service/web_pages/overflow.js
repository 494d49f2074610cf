// Text that overflows its container. Runs in the page.

// Lists texts that extend beyond their panel, button or dialog. Text that can be scrolled is exempt.
export function stickingOut() {
  const out = [];
  const texts = document.createTreeWalker(document.querySelector("dialog[open]") ?? document.body, NodeFilter.SHOW_TEXT);
  while (texts.nextNode()) {
    const element = texts.currentNode.parentElement;
    const box = element.closest("button, .button, .panel, dialog, header, main");
    if (!box || !element.checkVisibility() || element.closest(".unseen, .skip, select, pre, .scroll")) {
      continue;
    }
    const range = document.createRange();
    range.selectNodeContents(texts.currentNode);
    const text = range.getBoundingClientRect();
    const { left, right } = box.getBoundingClientRect();
    if (text.width > 0 && (text.left < left || text.right > right)) {
      out.push(texts.currentNode.data.trim());
    }
  }
  return out;
}
