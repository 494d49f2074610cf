#ifndef SERVER_FLEET_LOG_FRAME_STACK_WARMUP_H_
#define SERVER_FLEET_LOG_FRAME_STACK_WARMUP_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "server/fleet/log/logged_request.h"
#include "server/session/backend/request.h"

namespace procgen {

// Tracks whether environments' frame stacks can be redrawn from saved states, which contain no
// frames. With stacks of k frames, each environment must have been stepped k - 1 times since, or,
// in its episode at that time, not at all before.
// Threads: compatible.
class FrameStackWarmup {
 public:
  // All environments are as created.
  FrameStackWarmup(int32_t env_count, int32_t frame_stack);

  // Records the next entry of the log.
  void Add(int64_t number, const LoggedRequest& logged);
  // Nothing is known of earlier entries, at least of frames before the next number.
  void Forget();
  // Whether states of `range` saved after `number` reproduce the current stacks.
  bool IsComplete(Part range, int64_t number) const;

 private:
  void AddBegin(int32_t environment);
  int64_t& OldestStep(size_t environment) {
    return steps_[environment * needed_ + next_[environment]];
  }

  size_t needed_;                     // k - 1; 0: nothing is kept
  std::vector<int64_t> first_steps_;  // the first since the stack was empty    int64 [N]
  std::vector<int64_t> steps_;        // the last k - 1, a ring each            int64 [N, k - 1]
  std::vector<uint8_t> next_;         // index of the oldest entry of each ring         uint8 [N]
};

}  // namespace procgen

#endif  // SERVER_FLEET_LOG_FRAME_STACK_WARMUP_H_
