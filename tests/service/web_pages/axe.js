// axe-core in a page. Playwright's `evaluate` needs no permission of the page's Content-Security-Policy.

import { readFileSync } from "node:fs";

const AXE = readFileSync(new URL("node_modules/axe-core/axe.min.js", import.meta.url), "utf8");

// Lists violations of axe's rules: WCAG 2 A and AA, and best practices.
export async function axeViolations(page) {
  await page.evaluate(AXE);
  return page.evaluate(async () => {
    const { violations } = await window.axe.run(document);
    return violations.map(({ id, help, nodes }) => `${id} (${help}): ${nodes.map(({ html }) => html.slice(0, 80)).join(", ")}`);
  });
}
