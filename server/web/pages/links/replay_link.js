// Links to a step of a replay. An episode of a pool is identified by its place: { pool, environment, episode: its fingerprint }. A
// trace from elsewhere has no place, and only this tab can open its link.
//
// The subject of a replay is { source, name, place }: what is replayed (see replay/replay_run.js), its name and its place or null.

import { byId, element } from "../elements/elements.js";
import { sentence } from "../elements/notices.js";
import { sourceOfTrace } from "../replay/trace_source.js";
import { fetchEpisode, placeOf, sourceOfEpisode } from "../run/episode.js";
import { keptTrace } from "./traces.js";

const OTHER = "other_";  // prefix of the parameters of a second replay
const INTEGER = /^\d{1,9}$/;

// The place in a query, { place, step }: the place is null without a pool; without an episode it is the last one. Throws an Error
// for an invalid query.
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
  return { place: pool === null ? null : { pool, environment, episode: query.get("episode") ?? "last" }, step };
}

// The URL of a step, for the replay page or for the play page, which continues from it. `other`: the place of a second replay, or null.
export function placeAddress(path, place, step, other = null) {
  const others = Object.entries(other ?? {}).map(([name, value]) => [`${OTHER}${name}`, value]);
  return `${path}?${new URLSearchParams({ ...place, ...Object.fromEntries(others), step })}`;
}

// The place of the second replay in a query, or null.
export function otherPlaceIn(query) {
  const [pool, environment, episode] = ["pool", "environment", "episode"].map((name) => query.get(`${OTHER}${name}`));
  return pool && episode && INTEGER.test(environment ?? "") ? { pool, environment: Number(environment), episode } : null;
}

function isSamePlace(one, other) {
  return one?.pool === other?.pool && one?.environment === other?.environment && one?.episode === other?.episode;
}

// The subject of an episode of an environment; without `place.episode`, of its last one. Rejects with a UserError.
export async function fetchSubject(connection, place) {
  const episode = await fetchEpisode(connection, { episode: "last", ...place });
  return { source: sourceOfEpisode(episode), name: null, place: placeOf(place, episode) };
}

// The subject of a trace file. Throws a UserError.
export function subjectOfTrace({ bytes, name, place = null }) {
  return { source: sourceOfTrace(bytes), name, place };
}

// Returns { subject, step } of a link: its episode, or the trace that this tab keeps, if any. Throws an Error if it is invalid, or its
// episode is gone.
export async function followLink(connection, query) {
  const { place, step } = placeIn(query);
  const kept = keptTrace();
  if (place === null) {
    return { subject: kept && subjectOfTrace(kept), step };
  }
  try {
    return { subject: await fetchSubject(connection, place), step };
  } catch (error) {
    if (!["NOT_FOUND", "FAILED_PRECONDITION", "INVALID_ARGUMENT"].includes(error.code)) {
      throw error;
    }
    if (isSamePlace(place, kept?.place)) {
      return { subject: subjectOfTrace(kept), step };
    }
    throw new Error(`The episode of this link is gone. ${sentence(error.message)}`);
  }
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
