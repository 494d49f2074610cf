// Keys of the keyboard and of the touch pad, and the action that those held together stand for.

const NAMES = {
  ArrowLeft: "LEFT", ArrowRight: "RIGHT", ArrowUp: "UP", ArrowDown: "DOWN",
  KeyQ: "Q", KeyW: "W", KeyE: "E", KeyA: "A", KeyS: "S", KeyD: "D",
};

// The number of the action whose keys are all held; of several the one with most keys, then the first of the catalog.
// `actions`: the catalog's, with `number` and `keys`.
export function actionOf(actions, held) {
  const possible = actions.filter(({ keys }) => keys.every((key) => held.has(key)));
  return possible.reduce((best, action) => (action.keys.length > best.keys.length ? action : best)).number;
}

// Whether what has the focus takes letters and arrows for itself.
export function takesKeys(target) {
  return target.closest?.("input, select, textarea, dialog, summary") !== null;
}

// Which keys are held. One that was let go before it was asked for counts once, so that a short tap is a step.
export class Keys {
  #held = new Map();  // name -> number of things (a key, a button) that hold it
  #tapped = new Set();

  #onPress = () => {};

  // Listens to the keyboard of the page and to the buttons with data-key below `pad`. `onPress()` is called with each key.
  listen(pad, onPress) {
    this.#onPress = onPress;
    document.addEventListener("keydown", (event) => {
      const name = NAMES[event.code];
      if (!name || event.ctrlKey || event.metaKey || event.altKey || takesKeys(event.target)) {
        return;
      }
      event.preventDefault();
      if (!event.repeat) {
        this.#press(name);
      }
    });
    document.addEventListener("keyup", ({ code }) => NAMES[code] && this.#release(NAMES[code]));
    addEventListener("blur", () => this.#held.clear());
    for (const button of pad.querySelectorAll("[data-key]")) {
      this.#listenTo(button);
    }
  }

  // The names that are held, or were since the last time.
  take() {
    const names = new Set([...this.#held.keys(), ...this.#tapped]);
    this.#tapped.clear();
    return names;
  }

  #listenTo(button) {
    const names = button.dataset.key.split(" ");
    let isHeld = false;
    const set = (held) => {
      if (held !== isHeld) {
        isHeld = held;
        button.classList.toggle("held", held);
        names.forEach((name) => (held ? this.#press(name) : this.#release(name)));
      }
    };
    button.addEventListener("pointerdown", (event) => {
      button.setPointerCapture(event.pointerId);
      set(true);
    });
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
      button.addEventListener(end, () => set(false));
    }
    // By keyboard or a screen reader a press is a tap.
    button.addEventListener("click", ({ detail }) => {
      if (detail === 0) {
        names.forEach((name) => this.#tapped.add(name));
        this.#onPress();
      }
    });
    button.addEventListener("contextmenu", (event) => event.preventDefault());
  }

  #press(name) {
    this.#held.set(name, (this.#held.get(name) ?? 0) + 1);
    this.#tapped.add(name);
    this.#onPress();
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
