#ifndef SERVER_WEB_PLAY_AGENT_PATH_H_
#define SERVER_WEB_PLAY_AGENT_PATH_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "envcore/trace/trace.h"

namespace procgen::web {

// Where the agent is in the rows of one level.
struct AgentPath {
  int32_t first_row = 0;
  // One value per row, in fractions of an image of the whole level (FRAME_VIEW_LEVEL), from its top
  // left corner. If the level ends the episode, the last row is that of its last state.
  std::vector<float> x;
  std::vector<float> y;
};

// The first row of the level that `row` of a trace of one environment shows.
int32_t FirstRowOfLevel(const Trace& trace, int32_t row);

// Steps an environment from `snapshot`, its state at `snapshot_row`, through the level that begins
// at `first_row`. REQUIRES: snapshot_row <= first_row; the trace has one environment, which plays
// `game`. Errors: those of Environment::Restore.
absl::StatusOr<AgentPath> FollowAgent(const std::string& game, const Trace& trace,
                                      const std::string& snapshot, int32_t snapshot_row,
                                      int32_t first_row);

}  // namespace procgen::web

#endif  // SERVER_WEB_PLAY_AGENT_PATH_H_
