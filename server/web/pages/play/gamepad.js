// Gamepads, as keys of the game and buttons of the page.

import { notify } from "../elements/notices.js";

const STICK_MIN = 0.5;  // of 1; less is no direction
const DIRECTIONS = ["UP", "DOWN", "LEFT", "RIGHT"];
// Buttons of the W3C's standard gamepad, by number.
const FIRST_OF_CROSS = 12;  // up, down, left, right
const LETTERS = ["D", "A", "W", "S", "Q", "E"];  // the four on the right, from the lowest; the two in front
const RESTART = 8;
const PAUSE = 9;

// The keys of the game that a gamepad holds.
function keysOf({ axes, buttons }) {
  const [x = 0, y = 0] = axes;
  const stick = [y < -STICK_MIN, y > STICK_MIN, x < -STICK_MIN, x > STICK_MIN];
  return [
    ...DIRECTIONS.filter((_, i) => stick[i] || buttons[FIRST_OF_CROSS + i]?.pressed),
    ...LETTERS.filter((_, i) => buttons[i]?.pressed),
  ];
}

// Reads the gamepads at each frame while any is connected. `hold(names)` sets the keys that they hold; `act(name)` is called with
// "pause" or "restart" when its button is pressed.
export function listenToGamepads(hold, act) {
  let isReading = false;
  let pressed = new Set();
  const read = () => {
    const gamepads = navigator.getGamepads().filter((gamepad) => gamepad?.connected);
    hold([...new Set(gamepads.flatMap(keysOf))]);
    const now = new Set([[PAUSE, "pause"], [RESTART, "restart"]]
      .filter(([button]) => gamepads.some(({ buttons }) => buttons[button]?.pressed)).map(([, name]) => name));
    [...now].filter((name) => !pressed.has(name)).forEach(act);
    pressed = now;
    isReading = gamepads.length > 0;
    if (isReading) {
      requestAnimationFrame(read);
    }
  };
  addEventListener("gamepadconnected", () => {
    notify("Gamepad: stick or cross to move, the other buttons for the keys of the game, Start to pause, Back to restart.");
    if (!isReading) {
      read();
    }
  });
}
