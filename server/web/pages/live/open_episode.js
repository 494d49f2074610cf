// Opens episodes in the replay page.

import { placeAddress } from "../links/replay_link.js";
import { replayTrace } from "../links/traces.js";
import { ReplayRun } from "../replay/replay_run.js";
import { fetchEpisode, placeOf, sourceOfEpisode } from "../run/episode.js";
import { writeTrace } from "../run/trace_file.js";

// `place`: { pool, environment, episode: a fingerprint, "last" or "current" }. Rejects with a UserError. An episode that has not
// ended cannot be found again, so its trace is passed to the page.
export async function openEpisode(connection, place) {
  const episode = await fetchEpisode(connection, place);
  const ended = placeOf(place, episode);
  if (ended) {
    location.assign(placeAddress("/replay", ended, 0));
    return;
  }
  const run = await ReplayRun.open(connection, sourceOfEpisode(episode));
  run.close();
  replayTrace(writeTrace(run.recording), run.recording.fileName);
}
