// Links to a step of a replay. An episode of a pool is identified by its pool, environment and fingerprint; `source` has
// these as { pool, environment, episode }. A trace from elsewhere has no source, and only this tab can open its link.

import { byId, element } from "../elements/elements.js";
import { sentence } from "../elements/notices.js";
import { partOf } from "../elements/pictures.js";
import { keepTrace, keptTrace } from "./traces.js";

const INTEGER = /^\d{1,9}$/;

// The place in a query, { source, step }: source is null without a pool, episode is null for the last one. Throws an Error for an
// invalid query.
function placeIn(query) {
  const integer = (name) => {
    const text = query.get(name) ?? "0";
    if (!INTEGER.test(text)) {
      throw new Error(`The ${name} of this link is “${text}”, allowed: integers from 0.`);
    }
    return Number(text);
  };
  const [step, environment] = [integer("step"), integer("environment")];
  const pool = query.get("pool");
  return { source: pool === null ? null : { pool, environment, episode: query.get("episode") }, step };
}

// The URL of a step, for the replay page or for the play page, which continues from it.
export function placeAddress(path, source, step) {
  return `${path}?${new URLSearchParams({ ...source, step })}`;
}

// The source of an episode that `facts`, the answer of pool.episode, describe; null if it has not ended, as it has no identity yet.
export function sourceOf({ pool, environment, ended, fingerprint }) {
  return ended && fingerprint ? { pool, environment, episode: fingerprint } : null;
}

function isSameSource(one, other) {
  return one?.pool === other?.pool && one?.environment === other?.environment && one?.episode === other?.episode;
}

// The trace of an episode of an environment, { bytes, name, source }; without `episode`, of its last one.
export async function fetchEpisode(connection, { pool, environment, episode = null }) {
  const which = episode === null ? { selector: "last" } : { episode };
  const answer = await connection.call("pool.episode", { pool, environment, ...which });
  return { bytes: partOf(answer, "trace").content, name: answer.file_name, source: sourceOf(answer) };
}

// Returns { trace, step } of a link: its episode, or the trace that this tab keeps, if any. Throws an Error if it is invalid, or its
// episode is gone.
export async function followLink(connection, query) {
  const { source, step } = placeIn(query);
  const kept = keptTrace();
  if (source === null || isSameSource(source, kept?.source)) {
    return { trace: kept, step };
  }
  const trace = await fetchEpisode(connection, source).catch((error) => {
    throw ["NOT_FOUND", "FAILED_PRECONDITION", "INVALID_ARGUMENT"].includes(error.code)
      ? new Error(`The episode of this link is gone. ${sentence(error.message)}`) : error;
  });
  keepTrace(trace);
  return { trace, step };
}

// Reports a link that cannot be opened in #wrong, and offers the last episode of its environment.
export function showWrongLink(text, query) {
  const offers = [["/", "Live view"]];
  const [pool, environment] = [query.get("pool"), query.get("environment")];
  if (query.has("episode")) {
    offers.unshift([`/replay?${new URLSearchParams({ pool, environment })}`, `Last episode of environment ${environment}`]);
  }
  byId("wrong").replaceChildren(element("h2", {}, "No such replay"), element("p", {}, text),
    element("ul", { class: "offers" }, ...offers.map(([href, name]) => element("li", {}, element("a", { href }, name)))));
  byId("wrong").hidden = false;
}
