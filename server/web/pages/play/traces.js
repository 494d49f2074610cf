// The buttons of the play page that save, replay and copy what is played.

import { byId } from "../elements/elements.js";
import { notify } from "../elements/notices.js";
import { copy } from "../export/clipboard.js";
import { levelProgram } from "../export/python_code.js";
import { replayTrace, saveTrace } from "../links/traces.js";
import { writeTrace } from "../run/trace_file.js";

// `current()` returns what is played: { play, level, hello }. `stop()` is called before the trace is read.
export function listenToTraceButtons(current, stop) {
  const withRecording = (use) => {
    stop();
    const { recording } = current().play;
    use(writeTrace(recording), recording.fileName, recording.fingerprints.at(-1));
  };
  byId("save").addEventListener("click", () => withRecording((bytes, name, fingerprint) => {
    saveTrace(bytes, name);
    notify(`Saved ${name}, ${fingerprint ? `fingerprint ${fingerprint}` : "episode not finished"}.`);
  }));
  byId("replay").addEventListener("click", () => withRecording((bytes, name) => replayTrace(bytes, name)));
  byId("copy-python").addEventListener("click", () => {
    const { level, hello } = current();
    copy(levelProgram(level, hello), "a program with this level");
  });
}
