// Continues a replay: the play page with the link of a step.

import { followLink, showWrongLink } from "../links/replay_link.js";
import { attempt } from "../page.js";

// The replay that a link continues, { trace, step }; null if there is none, which is reported.
export async function followBranch(connection, query) {
  try {
    const branch = await attempt(() => followLink(connection, query));
    if (branch && !branch.trace) {
      throw new Error("This link continues a replay that only the tab with its trace has.");
    }
    return branch;
  } catch (error) {
    showWrongLink(error.message, query);
    return null;
  }
}
