// Moves through the frames of a replay: to a chosen one, or through all of them at a speed.

export const STEPS_PER_SECOND = 15;  // at speed 1
export const FRAMES_PER_SECOND_MAX = 30;  // above, frames are skipped
const ROWS_AHEAD = 6;  // requested at once while the player runs, which hides the latency of a long line

export class Player {
  #rows = null;     // null: no replay
  #frames = null;
  #wanted = 0;      // the index of the requested frame
  #shown = -1;      // the index of the shown frame
  #isRunning = false;
  #isBusy = false;
  #speed = 1;
  #timer = null;
  #onWant;
  #onShow;
  #onRun;

  // `onWant(index)` is called when a frame is requested, `onShow(index, view, rows)` draws it and may return a
  // promise (`rows`: its row and those that are requested ahead), `onRun(isRunning)` is called when the player starts or stops.
  constructor({ onWant, onShow, onRun }) {
    this.#onWant = onWant;
    this.#onShow = onShow;
    this.#onRun = onRun;
  }

  get wanted() {
    return this.#wanted;
  }

  get isRunning() {
    return this.#isRunning;
  }

  get speed() {
    return this.#speed;
  }

  set speed(value) {
    this.#speed = value;
    this.#setTimer();
  }

  // Shows the frame `index` of a replay.
  open(rows, frames, index) {
    this.#rows = rows;
    this.#frames = frames;
    this.#shown = -1;
    return this.seek(index);
  }

  close() {
    this.run(false);
    this.#rows = null;
  }

  // Stops, and shows a frame.
  go(index) {
    this.run(false);
    return this.seek(index);
  }

  // Shows a frame. During a request, only the frame requested last waits.
  async seek(index) {
    if (!this.#rows) {
      return;
    }
    this.#wanted = Math.max(0, Math.min(index, this.#frames.last));
    this.#onWant(this.#wanted);
    if (this.#isBusy) {
      return;
    }
    this.#isBusy = true;
    while (this.#rows && this.#shown !== this.#wanted) {
      const asked = this.#wanted;
      const rows = this.#rows;
      const ahead = this.#ahead(asked);
      const view = await rows.fetch(ahead);
      if (rows !== this.#rows) {
        continue;
      }
      if (!view) {
        break;
      }
      this.#shown = asked;
      await this.#onShow(asked, view, ahead);
    }
    this.#isBusy = false;
  }

  // Starts or stops; from the end it starts again at the beginning.
  toggle() {
    if (!this.#rows) {
      return;
    }
    if (!this.#isRunning && this.#wanted === this.#frames.last) {
      this.seek(0);
    }
    this.run(!this.#isRunning);
  }

  run(value) {
    this.#isRunning = value;
    this.#setTimer();
    this.#onRun(value);
  }

  // The rows of a frame and, while the player runs, of the next ones.
  #ahead(index) {
    const count = this.#isRunning ? ROWS_AHEAD : 1;
    const indexes = Array.from({ length: count }, (_, i) => Math.min(index + i * this.#stride, this.#frames.last));
    return [...new Set(indexes.map((each) => this.#frames.at(each).row))];
  }

  get #stride() {
    return Math.ceil(STEPS_PER_SECOND * this.#speed / FRAMES_PER_SECOND_MAX);
  }

  #setTimer() {
    clearInterval(this.#timer);
    if (this.#isRunning) {
      this.#timer = setInterval(() => this.#advance(), 1000 * this.#stride / (STEPS_PER_SECOND * this.#speed));
    }
  }

  #advance() {
    if (this.#isBusy) {
      return;
    }
    if (this.#wanted < this.#frames.last) {
      this.seek(this.#wanted + this.#stride);
    } else {
      this.run(false);
    }
  }
}
