#ifndef PROCGEN_CLIENT_LOOK_TRIAL_H_
#define PROCGEN_CLIENT_LOOK_TRIAL_H_

#include <cstdint>

#include "absl/time/time.h"

namespace procgen_client {

// Finds out whether a learner has more answers in a time if it looks for each of them before it
// sleeps, giving its core to whoever wants it. It saves the server the time to wake it; but where
// the scheduler counts both in different groups (sessions, containers), it takes their core. Both
// ways are tried for some answers, one after the other, from time to time.
// Threads: compatible.
class LookTrial {
 public:
  static constexpr int32_t kTriedAnswers = 32;      // each way
  static constexpr int32_t kDecidedAnswers = 2048;  // until they are tried again

  // Whether to look for the next answer.
  bool looks() const { return looks_; }
  // An answer has arrived. `now` is asked for with the last of a stage only.
  template <typename Now>
  void OnAnswer(Now now) {
    if (--answers_left_ <= 0) {
      EndStage(now());
    }
  }

 private:
  enum class Stage : uint8_t { kWarmUp, kSleeping, kLooking, kDecided };

  void EndStage(absl::Time now);

  Stage stage_ = Stage::kWarmUp;
  int32_t answers_left_ = kTriedAnswers;
  bool looks_ = false;
  absl::Time begin_;              // of the stage
  absl::Duration sleeping_time_;  // that the answers took without looking
};

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_LOOK_TRIAL_H_
