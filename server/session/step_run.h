#ifndef SERVER_SESSION_STEP_RUN_H_
#define SERVER_SESSION_STEP_RUN_H_

#include <cstdint>
#include <vector>

#include "server/session/request.h"

namespace procgen {

// Successive steps of one slice of a pool. What seldom is, is kept beside the actions.
struct StepRun {
  struct Reward {
    int32_t step = 0;  // index in the run
    int32_t environment = 0;
    float reward = 0;
  };
  struct Level {
    int32_t step = 0;
    int32_t environment = 0;
    int32_t level_seed = 0;
  };

  Part slice;
  std::vector<int64_t> numbers;  // of the steps, rising                      [steps]
  std::vector<uint8_t> actions;  // 255: kEndEpisodeAction                    [steps, slice.count]
  // How often an action was taken; empty: once each.                         [steps, slice.count]
  std::vector<uint16_t> counts;
  std::vector<Reward> rewards;      // that are not 0
  std::vector<Level> later_levels;  // that began in the midst of an episode
  int64_t reserved_bytes = 0;

  bool Holds(int32_t environment) const {
    return environment >= slice.first && environment < slice.first + slice.count;
  }
};

}  // namespace procgen

#endif  // SERVER_SESSION_STEP_RUN_H_
