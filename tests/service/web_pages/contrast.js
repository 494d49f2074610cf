// Contrast of all visible elements, as WCAG 2 defines it. Runs in the page.

// Lists violations: text below 4.5 (large text: 3), borders of controls below 3. Disabled elements are exempt.
export function lowContrasts() {
  const channels = (color) => color.match(/[\d.]+/g).map(Number);
  // `color` blended over `behind`, both [r, g, b, a].
  const over = ([r, g, b, a = 1], behind) => [r, g, b].map((value, i) => value * a + behind[i] * (1 - a));
  const background = (element) => {
    if (!element) {
      return [255, 255, 255];
    }
    const color = channels(getComputedStyle(element).backgroundColor);
    return color[3] === undefined || color[3] === 1 ? color : over(color, background(element.parentElement));
  };
  const luminance = (color) => {
    const [r, g, b] = color.map((value) => {
      const part = value / 255;
      return part <= 0.04045 ? part / 12.92 : ((part + 0.055) / 1.055) ** 2.4;
    });
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const contrast = (one, other) => {
    const [low, high] = [luminance(one), luminance(other)].sort((a, b) => a - b);
    return (high + 0.05) / (low + 0.05);
  };
  const isSeen = (element) => element.checkVisibility({ opacityProperty: true, visibilityProperty: true })
    && !element.closest(".unseen, .skip, :disabled");
  const low = [];

  const texts = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (texts.nextNode()) {
    const element = texts.currentNode.parentElement;
    const text = texts.currentNode.data.trim();
    const style = getComputedStyle(element);
    const size = parseFloat(style.fontSize);
    if (text === "" || size === 0 || !isSeen(element) || element.closest("script, style")) {
      continue;
    }
    const behind = background(element);
    const ratio = contrast(over(channels(style.color), behind), behind);
    const isLarge = size >= 24 || (size >= 18.66 && Number(style.fontWeight) >= 700);
    if (ratio < (isLarge ? 3 : 4.5)) {
      low.push(`"${text}": ${ratio.toFixed(2)}`);
    }
  }
  const bounded = "button, select, input:not([type=radio], [type=checkbox], [type=range], [type=file])";
  for (const control of document.querySelectorAll(bounded)) {
    if (!isSeen(control) || control.querySelector("canvas")) {
      continue;
    }
    const around = background(control.parentElement);
    const style = getComputedStyle(control);
    const ratio = Math.max(contrast(background(control), around), contrast(over(channels(style.borderColor), around), around));
    if (ratio < 3) {
      low.push(`bounds of ${control.outerHTML.slice(0, 60)}: ${ratio.toFixed(2)}`);
    }
  }
  return low;
}
