// Continues a replay: the play page with the link of a step.

import { UserError } from "../connection/errors.js";
import { followLink, showWrongLink } from "../links/replay_link.js";
import { attempt } from "../page.js";
import { ReplayRun } from "../replay/replay_run.js";
import { PlayRun } from "./play_run.js";

// The replay that a link continues, { subject, step }; null if there is none, which is reported.
export async function followBranch(connection, query) {
  try {
    const branch = await attempt(() => followLink(connection, query));
    if (branch && !branch.subject) {
      throw new Error("This link continues a replay that only the tab with its trace has.");
    }
    return branch;
  } catch (error) {
    showWrongLink(error.message, query);
    return null;
  }
}

// Starts the play of a branch. Rejects with a UserError.
export async function openBranch(connection, { subject: { source }, step }, sizePx) {
  if (step > source.actions.length) {
    throw new UserError("INVALID_ARGUMENT", `The step is ${step}, the replay has ${source.actions.length} steps.`);
  }
  const start = { ...source, actions: source.actions.slice(0, step), check: () => null };
  return PlayRun.continue(await ReplayRun.open(connection, start, "play"), sizePx);
}
