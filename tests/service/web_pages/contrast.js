// Contrast of visible controls with what is around them, as WCAG 2 defines it; axe checks that of text. Runs in the page.

// Lists controls whose ground and border are both below 3. Disabled ones are exempt.
export function faintControls() {
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
  const bounded = "button, select, input:not([type=radio], [type=checkbox], [type=range], [type=file])";
  for (const control of document.querySelectorAll(bounded)) {
    if (!isSeen(control) || control.querySelector("canvas")) {
      continue;
    }
    const around = background(control.parentElement);
    const style = getComputedStyle(control);
    const ratio = Math.max(contrast(background(control), around), contrast(over(channels(style.borderColor), around), around));
    if (ratio < 3) {
      low.push(`${control.outerHTML.slice(0, 60)}: ${ratio.toFixed(2)}`);
    }
  }
  return low;
}
