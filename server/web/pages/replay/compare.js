// A second replay beside the first, at the same step, with their first difference.

import { byId, setOptions, setText } from "../elements/elements.js";
import { drawImage } from "../elements/pictures.js";
import { fetchSubject, subjectOfTrace } from "../links/replay_link.js";
import { attempt } from "../page.js";
import { kindOf } from "../run/kinds.js";
import { firstDifference } from "./difference.js";
import { ReplayRun } from "./replay_run.js";
import { Rows } from "./rows.js";
import { imageOf } from "./view.js";

export class Comparison {
  #current;
  #onChange;
  #subject = null;    // { source, name }
  #replay = null;     // a ReplayRun
  #rows = null;
  #difference = null;

  // `current()` returns what the page shows: { connection, replay, actionNames }. `onChange(row)` is called when another replay is
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
    byId("compare").addEventListener("toggle", () => byId("compare").open && this.#listPools());
    byId("other-pool").addEventListener("submit", (event) => {
      event.preventDefault();
      this.#openEpisode(event.target.elements);
    });
    byId("go-difference").addEventListener("click", () => onChange(this.#difference.row));
    byId("end-compare").addEventListener("click", () => this.#end());
  }

  // The row of the first difference, or null.
  get row() {
    return this.#difference?.row ?? null;
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
    this.#onChange(null);
  }

  #tell() {
    byId("other-figure").hidden = false;
    byId("end-compare").hidden = false;
    byId("go-difference").hidden = !this.#difference;
    const { row, name, values } = this.#difference ?? {};
    setText(byId("difference"), this.#difference
      ? `First difference at step ${row}: the ${name} is ${values[0]}, in ${this.#subject.name} it is ${values[1]}.`
      : `No difference from ${this.#subject.name}.`);
    setText(byId("go-difference"), `Go to step ${row}`);
  }

  #end() {
    this.#replay?.close();
    this.#rows = null;
    this.#subject = null;
    this.#difference = null;
    byId("other-figure").hidden = true;
    byId("end-compare").hidden = true;
    byId("go-difference").hidden = true;
    setText(byId("difference"), "");
    this.#onChange(null);
  }

  // Offers the pools that there are now.
  async #listPools() {
    const { connection } = this.#current();
    const list = await attempt(() => connection.call("PoolService.ListPools"));
    if (list) {
      const pools = list.pools.filter(({ name }) => kindOf(name) === "pool");
      setOptions(byId("other-pool").elements.pool, pools.map(({ name, spec }) => [name, `${name}, ${spec.games.join(", ")}`]));
      byId("other-pool").hidden = pools.length === 0;
    }
  }

  async #openEpisode({ pool, environment }) {
    const { connection } = this.#current();
    const subject = await attempt(() => fetchSubject(connection, { pool: pool.value, environment: environment.valueAsNumber }));
    if (subject) {
      await this.#open({ ...subject, name: `${pool.value}, environment ${environment.value}` });
    }
  }
}
