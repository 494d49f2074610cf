// Saves episodes of a running pool from the live view.

// Enlarges environments of the first `count` of the open pool and requests their last episode, until one is returned.
// Which environments have ended an episode depends on the learner.
export async function replayLastEpisode(page, count) {
  const isOpen = () => new URL(page.url()).pathname === "/replay";
  for (let environment = 0; !isOpen(); environment = (environment + 1) % count) {
    await page.click(`#mosaic button[title='Environment ${environment}']`);
    await page.click("#keep-last");
    await Promise.race([page.waitForURL("**/replay?*"), page.locator("#large-problem", { hasText: /./ }).waitFor()]);
    if (!isOpen()) {
      await page.keyboard.press("Escape");
    }
  }
}
