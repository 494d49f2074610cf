#include "server/fleet/log/frame_stack_warmup.h"

#include <algorithm>
#include <limits>

#include "server/fleet/log/shard_request.h"

namespace procgen {
namespace {

constexpr int64_t kNone = std::numeric_limits<int64_t>::max();

}  // namespace

FrameStackWarmup::FrameStackWarmup(int32_t env_count, int32_t frame_stack)
    : needed_(static_cast<size_t>(std::max(frame_stack, 1) - 1)) {
  if (needed_ > 0) {
    const auto count = static_cast<size_t>(env_count);
    first_steps_.assign(count, kNone);
    steps_.assign(count * needed_, 0);
    next_.assign(count, 0);
  }
}

void FrameStackWarmup::Add(int64_t number, const LoggedRequest& logged) {
  if (needed_ == 0) {
    return;
  }
  const v1::StepPoolRequest& request = logged.request;
  if (request.has_step()) {
    const Part slice = SliceOf(request, 0);
    for (int32_t i = slice.first; i < slice.first + slice.count; ++i) {
      const auto environment = static_cast<size_t>(i);
      first_steps_[environment] = std::min(first_steps_[environment], number);
      OldestStep(environment) = number;
      next_[environment] = static_cast<uint8_t>((next_[environment] + size_t{1}) % needed_);
    }
  }
  // Environments in a reset are not stepped.
  for (const v1::Reset& reset : request.step().resets()) {
    AddBegin(reset.environment());
  }
  for (const v1::Reset& reset : request.reset().resets()) {
    AddBegin(reset.environment());
  }
  for (const v1::State& state : logged.states) {
    AddBegin(state.environment());
  }
}

void FrameStackWarmup::AddBegin(int32_t environment) {
  first_steps_[static_cast<size_t>(environment)] = kNone;
}

void FrameStackWarmup::Forget() {
  std::fill(first_steps_.begin(), first_steps_.end(), 0);
  std::fill(steps_.begin(), steps_.end(), 0);
}

bool FrameStackWarmup::IsComplete(Part range, int64_t number) const {
  if (needed_ == 0) {
    return true;
  }
  for (int32_t i = range.first; i < range.first + range.count; ++i) {
    const auto environment = static_cast<size_t>(i);
    if (first_steps_[environment] <= number &&
        steps_[environment * needed_ + next_[environment]] <= number) {
      return false;
    }
  }
  return true;
}

}  // namespace procgen
