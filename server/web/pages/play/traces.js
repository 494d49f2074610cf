// The buttons of the play page that save, replay and copy what is played.

import { byId } from "../elements/elements.js";
import { notify } from "../elements/notices.js";
import { partOf } from "../elements/pictures.js";
import { copy } from "../export/clipboard.js";
import { levelProgram } from "../export/python_code.js";
import { replayTrace, saveTrace } from "../links/traces.js";
import { attempt } from "../page.js";

// `current()` returns what is played: { connection, view, level, catalog }. `stop()` is called before the trace is read.
export function listenToTraceButtons(current, stop) {
  const withTrace = async (use) => {
    stop();
    const { connection, view } = current();
    const trace = await attempt(() => connection.call("play.trace", { play: view.play }));
    if (trace) {
      use(partOf(trace, "trace").content, trace.file_name, trace.fingerprint);
    }
  };
  byId("save").addEventListener("click", () => withTrace((bytes, name, fingerprint) => {
    saveTrace(bytes, name);
    notify(`Saved ${name}, ${fingerprint ? `fingerprint ${fingerprint}` : "episode not finished"}.`);
  }));
  byId("replay").addEventListener("click", () => withTrace((bytes, name) => replayTrace(bytes, name)));
  byId("copy-python").addEventListener("click", () => {
    const { level, catalog } = current();
    copy(levelProgram(level, catalog), "a program with this level");
  });
}
