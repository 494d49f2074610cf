// Plays by keyboard, one step at a time, so a sequence of keys always gives the same steps.

import { figure, waitForText } from "./browser.js";

// Reaches the coin of coinrun's level 1000, easy: the held keys and their number of steps.
export const COINRUN_1000 = [[[], 1], [["ArrowRight"], 2], [["ArrowRight", "ArrowUp"], 18], [["ArrowRight"], 14]];
export const COINRUN_1000_STEPS = 35;
// The same as actions.
const ACTION_OF_KEYS = { "": 4, ArrowRight: 7, "ArrowRight+ArrowUp": 8 };
export const COINRUN_1000_ACTIONS = COINRUN_1000.flatMap(([keys, count]) => Array(count).fill(ACTION_OF_KEYS[keys.join("+")]));

export const COINRUN_1000_PATH = "/play?game=coinrun&mode=easy&level=1000";

// Plays a recorded sequence on a play page that waits for its first key.
export async function playKeys(page, sequence) {
  const step = figure(page, "#figures", "Step");
  await waitForText(step, /^0$/);
  let held = [];
  let steps = 0;
  // Pauses with the first step, so that held keys do not run the level.
  for (const [keys, count] of sequence) {
    for (const key of held.filter((name) => !keys.includes(name))) {
      await page.keyboard.up(key);
    }
    for (const key of keys.filter((name) => !held.includes(name))) {
      await page.keyboard.down(key);
    }
    held = keys;
    for (let i = 0; i < count; i += 1) {
      steps += 1;
      await page.keyboard.press(".");
      await waitForText(step, new RegExp(`^${steps}$`));
    }
  }
  for (const key of held) {
    await page.keyboard.up(key);
  }
}
