#ifndef SERVER_WEB_PLAY_EPISODE_TRACE_H_
#define SERVER_WEB_PLAY_EPISODE_TRACE_H_

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "procgen_client/client.h"
#include "server/web/json/message.h"
#include "server/web/play/recording.h"

namespace procgen::web {

// Selects an episode of an environment of a running pool.
struct EpisodeChoice {
  std::string pool;
  int32_t environment = 0;
  bool is_current = false;   // the running episode; otherwise the last finished one
  uint64_t fingerprint = 0;  // not 0: of a finished one
};

// Reads the members pool, environment, and selector or episode of a request.
EpisodeChoice ReadEpisodeChoice(RequestParams* params);

// An episode of a pool, replayed to obtain all of its rows.
struct EpisodeTrace {
  Json facts;  // the answer of pool.episode
  Recording recording;
};

// Replays an episode. Blocks. Errors: those of GetEpisode; FAILED_PRECONDITION the episode cannot
// be replayed, or not from options alone, which is all that a trace contains; CANCELLED
// `is_stopping`.
absl::StatusOr<EpisodeTrace> TraceOfEpisode(std::shared_ptr<procgen_client::Client> client,
                                            const EpisodeChoice& choice,
                                            const std::atomic<bool>& is_stopping);

}  // namespace procgen::web

#endif  // SERVER_WEB_PLAY_EPISODE_TRACE_H_
