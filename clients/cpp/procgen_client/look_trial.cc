#include "procgen_client/look_trial.h"

namespace procgen_client {
namespace {

// Who sleeps leaves the core to others, so looking must save as much as this.
constexpr double kWorthwhile = 0.97;

}  // namespace

void LookTrial::EndStage(absl::Time now) {
  const absl::Duration time = now - begin_;
  begin_ = now;
  answers_left_ = kTriedAnswers;
  switch (stage_) {
    case Stage::kWarmUp:
    case Stage::kDecided:
      stage_ = Stage::kSleeping;
      looks_ = false;
      return;
    case Stage::kSleeping:
      sleeping_time_ = time;
      stage_ = Stage::kLooking;
      looks_ = true;
      return;
    case Stage::kLooking:
      stage_ = Stage::kDecided;
      looks_ = time < kWorthwhile * sleeping_time_;
      answers_left_ = kDecidedAnswers;
      return;
  }
}

}  // namespace procgen_client
