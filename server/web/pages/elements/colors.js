// Colours of the style sheet, for canvases.

// The current values of the named colours of the style sheet: colorsOf("ink", "line") -> { ink, line }.
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
