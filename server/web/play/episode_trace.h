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

// Which episode of which environment of a running pool.
struct EpisodeChoice {
  std::string pool;
  int32_t environment = 0;
  bool is_current = false;  // the one under way; otherwise the last that ended
};

// Takes the members pool, environment and selector of a request.
EpisodeChoice ReadEpisodeChoice(RequestParams* params);

// An episode of a pool, played again so that there are all rows of it.
struct EpisodeTrace {
  Json facts;  // as pool.episode answers
  Recording recording;
};

// Blocks. Errors: those of GetEpisode; FAILED_PRECONDITION it cannot be played again, or not by
// options alone, which is all that a trace tells; CANCELLED `is_stopping`.
absl::StatusOr<EpisodeTrace> TraceOfEpisode(std::shared_ptr<procgen_client::Client> client,
                                            const EpisodeChoice& choice,
                                            const std::atomic<bool>& is_stopping);

}  // namespace procgen::web

#endif  // SERVER_WEB_PLAY_EPISODE_TRACE_H_
