// A second replay beside the first, at the same step, with their first difference.

import { byId, setText } from "../elements/elements.js";
import { drawImage } from "../elements/pictures.js";
import { fetchSubject, subjectOfTrace } from "../links/replay_link.js";
import { attempt } from "../page.js";
import { firstDifference } from "./difference.js";
import { OtherEpisodes } from "./other_episodes.js";
import { ReplayRun } from "./replay_run.js";
import { Rows } from "./rows.js";
import { imageOf } from "./view.js";

export class Comparison {
  #current;
  #onChange;
  #subject = null;    // see links/replay_link.js
  #replay = null;     // a ReplayRun
  #rows = null;
  #difference = null;

  // `current()` returns what the page shows: { connection, replay, place, actionNames }. `onChange(row)` is called when another replay is
  // shown or none; `row`: the one to go to, or null.
  constructor(current, onChange) {
    this.#current = current;
    this.#onChange = onChange;
    byId("other-file").addEventListener("change", async ({ target }) => {
      const [file] = target.files;
      if (file) {
        this.#openFile(file.name, new Uint8Array(await file.arrayBuffer()));
      }
      target.value = "";
    });
    const episodes = new OtherEpisodes(current, (place) => this.openPlace(place));
    byId("compare").addEventListener("toggle", () => byId("compare").open && current().replay && episodes.listPools());
    byId("go-difference").addEventListener("click", () => onChange(this.#difference.row));
    byId("end-compare").addEventListener("click", () => this.#end());
  }

  // The place of the second replay (see links/replay_link.js), or null.
  get place() {
    return this.#subject?.place ?? null;
  }

  // Compares with an episode of a pool.
  async openPlace(place) {
    const { connection } = this.#current();
    const subject = await attempt(() => fetchSubject(connection, place));
    if (subject) {
      byId("compare").open = true;
      await this.#open({ ...subject, name: `${place.pool}, environment ${place.environment}` });
    }
  }

  // The connection is lost, and with it the replay on the server.
  lose() {
    this.#rows = null;
  }

  // Opens the second replay again, for a new first one or after a reconnect.
  reopen() {
    if (this.#subject) {
      this.#open(this.#subject);
    }
  }

  // Draws the row of a frame, or the last if there are fewer. `rows`: that row and those to be requested ahead.
  async show(frame, rows = [frame.row]) {
    if (!this.#rows) {
      return;
    }
    const wanted = [...new Set(rows.map((each) => Math.min(each, this.#replay.rows - 1)))];
    const [row] = wanted;
    const view = await this.#rows.fetch(wanted);
    if (view) {
      await drawImage(byId("other"), imageOf(view, frame, "human"));
      byId("other").setAttribute("aria-label", `${this.#subject.name}, step ${row}, as people see it`);
      setText(byId("other-name"), `${this.#subject.name}, step ${row} of ${this.#replay.rows - 1}`);
    }
  }

  #openFile(name, bytes) {
    return attempt(() => this.#open(subjectOfTrace({ name, bytes })));
  }

  async #open(subject) {
    const { connection, replay, actionNames } = this.#current();
    this.#replay?.close();
    this.#rows = null;
    const opened = await attempt(() => ReplayRun.open(connection, subject.source));
    if (!opened) {
      return;
    }
    this.#subject = subject;
    this.#replay = opened;
    this.#rows = new Rows(opened);
    this.#difference = firstDifference(replay, opened, actionNames);
    this.#tell();
  }

  // Describes the comparison, if there is one.
  #tell() {
    const isOpen = this.#subject !== null;
    byId("other-figure").hidden = !isOpen;
    byId("end-compare").hidden = !isOpen;
    byId("go-difference").hidden = !this.#difference;
    const { row, name, values } = this.#difference ?? {};
    setText(byId("difference"), this.#difference
      ? `First difference at step ${row}: the ${name} is ${values[0]}, in ${this.#subject.name} it is ${values[1]}.`
      : isOpen ? `No difference from ${this.#subject.name}.` : "");
    setText(byId("go-difference"), `Go to step ${row}`);
    this.#onChange(null);
  }

  #end() {
    this.#replay?.close();
    this.#rows = null;
    this.#subject = null;
    this.#difference = null;
    this.#tell();
  }
}
