// A replay: a pool of one environment that repeats recorded actions, and shows any row.

import { Environment } from "../run/environment.js";
import { Recording } from "../run/recording.js";
import { sliceSpec } from "../run/spec.js";

const SNAPSHOTS_MAX = 256;       // 1 to 12 kB each
const SNAPSHOT_ROWS_MIN = 64;    // between two of them
const STEPS_AHEAD = 128;         // sent before they are answered
const HUMAN_SIZE_PX = 512;

// A source is { games, mode, options, envCount, environment, actions, annotations: AnnotationSeries of the learner's steps,
// rowOfStep(step): the row that a step led to }, and endsAfter(index): whether an episode is known to end with
// an action; check(recording): the first difference of the replay from what was recorded, { row, field, expected, got }, or null.
export class ReplayRun {
  #environment;
  #source;
  #snapshots = [];           // [row, state], by row; while all is replayed, promises of states
  #snapshotRows;
  #position = 0;             // the row of the environment, once all requests are executed
  #path = null;              // promise of { firstRow, places } of the level that was mapped last
  recording = null;
  difference = null;

  // Opens a replay and replays all actions. Rejects with a UserError. `kind`: of the pool.
  static async open(connection, source, kind = "replay") {
    const environment = await Environment.start(connection, kind, sliceSpec(source));
    const run = new ReplayRun(environment, source);
    try {
      await run.#playAll();
      run.difference = source.check(run.recording);
    } catch (error) {
      environment.close();
      throw error;
    }
    return run;
  }

  constructor(environment, source) {
    this.#environment = environment;
    this.#source = source;
    this.#snapshotRows = Math.max(SNAPSHOT_ROWS_MIN, Math.floor(source.actions.length / SNAPSHOTS_MAX) + 1);
  }

  get environment() {
    return this.#environment;
  }

  get source() {
    return this.#source;
  }

  get rows() {
    return this.recording.rows;
  }

  close() {
    this.#environment.close();
  }

  // Resolves to what a page shows of a row, with `images` { agent, human } and, where an episode has ended, the `finalImages` of it.
  // Rows may be requested ahead.
  async seek(row, sizePx = HUMAN_SIZE_PX) {
    const isEnd = this.recording.isEnd(row);
    this.#goTo(isEnd ? row - 1 : row);
    let final = null;
    if (isEnd) {
      this.#environment.step(this.#source.actions[row - 1]);
      final = this.#environment.look(sizePx);
      this.#environment.step(0);
      this.#position = row;
    }
    const current = this.#environment.look(sizePx);
    return { ...this.recording.viewOf(row), finalImages: await final, images: await current };
  }

  // Resolves to the whole level at a row as `image`, and the `places` of the agent in this level from row `firstRow` on.
  async map(row, sizePx) {
    const firstRow = this.recording.levelStart(row);
    if (this.#path?.firstRow !== firstRow) {
      this.#path = { firstRow, places: this.#follow(firstRow) };
    }
    this.#goTo(row);
    const image = this.#environment.level(sizePx);
    return { firstRow, places: await this.#path.places, image: await image, levelSeed: this.recording.levelSeeds[row] };
  }

  // Where the agent is in the rows of a level. Where the level ends its episode, the last place is that before the next one begins.
  #follow(firstRow) {
    this.#goTo(firstRow);
    const places = [this.#environment.place()];
    for (let row = firstRow + 1, isDone = false; row < this.rows && !isDone; row += 1) {
      const isEnd = this.recording.isEnd(row);
      isDone = isEnd || this.recording.prevLevelComplete[row];
      this.#environment.step(this.#source.actions[row - 1]);
      if (isEnd || !isDone) {
        places.push(this.#environment.place());
      }
      if (isEnd) {
        this.#environment.step(0);
      }
      this.#position = row;
    }
    return Promise.all(places);
  }

  async #playAll() {
    this.#snapshots = [[0, this.#environment.save()]];
    this.recording = new Recording(this.#source, await this.#environment.observe());
    const isOther = await this.#play(this.#source.endsAfter);
    if (isOther) {
      // An episode ended at another action than recorded: from the snapshot before, and waiting for each row.
      const [row, state] = this.#nearest(this.rows - 1);
      this.#snapshots = this.#snapshots.filter(([at]) => at <= row);
      this.recording.truncate(row + 1);
      this.#environment.restore(await state);
      await this.#play(() => true);
    }
    this.#snapshots = await Promise.all(this.#snapshots.map(async ([row, state]) => [row, await state]));
    this.#position = this.rows - 1;
  }

  // Plays the actions that are not in the recording yet. Steps are sent ahead, except after those that may end an episode. Returns
  // whether another one did.
  async #play(mayEnd) {
    const { actions } = this.#source;
    const sent = [];
    for (let next = this.rows - 1; next < actions.length; next += 1) {
      sent.push([actions[next], this.#environment.step(actions[next])]);
      const isLast = next + 1 === actions.length;
      while (sent.length > 0 && (isLast || sent.length >= STEPS_AHEAD || mayEnd(next))) {
        const [action, answer] = sent.shift();
        const row = await answer;
        if (row.hasEnded && sent.length > 0) {
          return true;
        }
        this.recording.add(action, row, row.hasEnded ? await this.#environment.step(0) : null);
      }
      if ((next + 1) % this.#snapshotRows === 0) {
        this.#snapshots.push([next + 1, this.#environment.save()]);
      }
    }
    return false;
  }

  // The last snapshot at or before a row.
  #nearest(row) {
    return this.#snapshots.findLast(([at]) => at <= row);
  }

  // Sends the requests that bring the environment to a row.
  #goTo(row) {
    const [at, state] = this.#nearest(row);
    if (this.#position > row || at > this.#position) {
      this.#position = at;
      this.#environment.restore(state);
    }
    while (this.#position < row) {
      this.#advance();
    }
  }

  // Takes the next step, and begins the next episode after an end.
  #advance() {
    this.#environment.step(this.#source.actions[this.#position]);
    this.#position += 1;
    if (this.recording.isEnd(this.#position)) {
      this.#environment.step(0);
    }
  }
}
