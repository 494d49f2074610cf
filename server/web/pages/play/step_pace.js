// When a play sends its steps, and at which size it asks for the human view.

const SIZES_PX = [512, 256, 128];
const IN_FLIGHT_MAX = 6;  // steps without a view: 15 steps a second on a line with a latency of 0.4 s
const STEPS_COUNTED = 15;
const STEPS_LATE_MAX = 3;

export class StepPace {
  #size = 0;  // index of SIZES_PX
  #counted = 0;
  #late = 0;

  // The size of the human view; smaller if larger ones do not arrive as fast as the game runs.
  get sizePx() {
    return SIZES_PX[this.#size];
  }

  // Called when a step is due; returns whether it may be sent. `inFlight`: the number of unanswered ones; `shownPx`: the size of
  // the human view that is shown.
  mayStep(inFlight, shownPx) {
    const isLate = inFlight >= IN_FLIGHT_MAX;
    if (shownPx === this.sizePx) {  // else views of the previous size are still on their way
      this.#count(isLate);
    }
    return !isLate;
  }

  // After a second with late steps, smaller views for a thin line.
  #count(isLate) {
    this.#counted += 1;
    this.#late += isLate ? 1 : 0;
    if (this.#counted === STEPS_COUNTED) {
      if (this.#late > STEPS_LATE_MAX) {
        this.#size = Math.min(this.#size + 1, SIZES_PX.length - 1);
      }
      this.#counted = 0;
      this.#late = 0;
    }
  }
}
