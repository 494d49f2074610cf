// Keys of the keyboard and of the touch pad, and the action that held keys select.

const NAMES = {
  ArrowLeft: "LEFT", ArrowRight: "RIGHT", ArrowUp: "UP", ArrowDown: "DOWN",
  KeyQ: "Q", KeyW: "W", KeyE: "E", KeyA: "A", KeyS: "S", KeyD: "D",
};

// The number of the action for the held keys, in the order in which they were pressed. The action contains the newest key and as
// many of the others as any action allows. No action both moves and shoots, so while keys for both are held, every second step
// has the newest key of the other kind. `actions`: the catalog's, with `number` and `keys`; `turn`: steps since the last press.
export function actionOf(actions, held, turn) {
  const best = (newest) => actions
    .filter(({ keys }) => keys.every((key) => held.has(key)) && (newest === undefined || keys.includes(newest)))
    .reduce((most, action) => (action.keys.length > most.keys.length ? action : most));
  const names = [...held];
  const action = best(names.at(-1));
  const other = names.findLast((name) => !action.keys.includes(name) && isLetter(name) !== isLetter(names.at(-1)));
  return (turn % 2 === 1 && other ? best(other) : action).number;
}

function isLetter(name) {
  return name.length === 1;
}

// Whether the focused element handles letters and arrows itself.
export function takesKeys(target) {
  return target.closest?.("input, select, textarea, dialog, summary") !== null;
}

// Whether an element is pressed with the space bar and the enter key.
export function isControl(target) {
  return target.closest("button, a, label") !== null;
}

// The keys of a button of the touch pad; none for no button.
function namesOf(button) {
  return button ? button.dataset.key.split(" ") : [];
}

// The held keys. A key that was released before it was read counts once, so that a short tap is a step.
export class Keys {
  #held = new Map();  // name -> number of keys and buttons that hold it
  #tapped = new Set();

  /** @type {(isRepeat: boolean) => void} */
  #onPress = () => {};

  // Listens to the keyboard of the page and to the buttons with data-key below `pad`. `onPress(isRepeat)` is called with each key, and
  // again while it is held.
  listen(pad, onPress) {
    this.#onPress = onPress;
    document.addEventListener("keydown", (event) => {
      const name = NAMES[event.code];
      if (!name || event.ctrlKey || event.metaKey || event.altKey || takesKeys(event.target)) {
        return;
      }
      event.preventDefault();
      if (event.repeat) {
        this.#onPress(true);
      } else {
        this.#press(name);
      }
    });
    document.addEventListener("keyup", ({ code }) => NAMES[code] && this.#release(NAMES[code]));
    addEventListener("blur", () => this.#held.clear());
    this.#listenTo(pad);
  }

  // The held keys in the order in which they were pressed, then those released since the last call.
  take() {
    const names = new Set([...this.#held.keys(), ...this.#tapped]);
    this.#tapped.clear();
    return names;
  }

  // Each finger presses the button under it, also after sliding.
  #listenTo(pad) {
    const touches = new Map();  // pointer -> button, or null outside of buttons
    pad.addEventListener("pointerdown", ({ pointerId, target }) => {
      pad.setPointerCapture(pointerId);
      this.#touch(touches, pointerId, target.closest("[data-key]"));
    });
    pad.addEventListener("pointermove", ({ pointerId, clientX, clientY }) => {
      if (touches.has(pointerId)) {
        const below = document.elementFromPoint(clientX, clientY)?.closest("[data-key]") ?? null;
        this.#touch(touches, pointerId, below);
      }
    });
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
      pad.addEventListener(end, ({ pointerId }) => {
        this.#touch(touches, pointerId, null);
        touches.delete(pointerId);
      });
    }
    // A click by keyboard or screen reader counts as a tap.
    pad.addEventListener("click", ({ detail, target }) => {
      const button = target.closest("[data-key]");
      if (detail === 0 && button) {
        namesOf(button).forEach((name) => this.#tapped.add(name));
        this.#onPress(false);
      }
    });
    pad.addEventListener("contextmenu", (event) => event.preventDefault());
  }

  #touch(touches, pointerId, button) {
    const left = touches.get(pointerId) ?? null;
    touches.set(pointerId, button);
    if (button === left) {
      return;
    }
    namesOf(button).forEach((name) => this.#press(name));
    namesOf(left).forEach((name) => this.#release(name));
    const touched = new Set(touches.values());
    [left, button].forEach((one) => one?.classList.toggle("held", touched.has(one)));
  }

  #press(name) {
    this.#held.set(name, (this.#held.get(name) ?? 0) + 1);
    this.#tapped.add(name);
    this.#onPress(false);
  }

  #release(name) {
    const left = (this.#held.get(name) ?? 0) - 1;
    if (left > 0) {
      this.#held.set(name, left);
    } else {
      this.#held.delete(name);
    }
  }
}
