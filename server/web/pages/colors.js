// The page's colours, for what is drawn on canvases.

// The colours of the style sheet with these names, as the theme has them now: colorsOf("ink", "line") -> { ink, line }.
export function colorsOf(...names) {
  const probe = document.createElement("span");
  probe.hidden = true;
  document.body.append(probe);
  const style = getComputedStyle(probe);
  const colors = Object.fromEntries(names.map((name) => {
    probe.style.color = `var(--${name})`;
    return [name, style.color];
  }));
  probe.remove();
  return colors;
}
