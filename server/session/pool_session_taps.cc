// What a PoolSession tells those who look on.

#include <algorithm>
#include <utility>

#include "server/session/pool_session.h"

namespace procgen {
namespace {

constexpr int kPausePerLook = 99;  // times as long as the look took
constexpr absl::Duration kPauseMax = absl::Seconds(1);

}  // namespace

void PoolSession::NoteLook(absl::Time begin_time) {
  const absl::Time now = SteadyNow();
  looks_from_ns_ = absl::ToUnixNanos(now + std::min((now - begin_time) * kPausePerLook, kPauseMax));
}

absl::Status PoolSession::AddTap(std::shared_ptr<PoolTap> tap) {
  absl::MutexLock lock(&taps_mutex_);
  if (taps_end_.ok()) {
    taps_.push_back(std::move(tap));
    is_tapped_ = true;
  }
  return taps_end_;
}

void PoolSession::RemoveTap(const PoolTap* tap) {
  absl::MutexLock lock(&taps_mutex_);
  std::erase_if(taps_, [tap](const std::shared_ptr<PoolTap>& each) { return each.get() == tap; });
  is_tapped_ = !taps_.empty();
}

void PoolSession::EndTaps(const absl::Status& reason) {
  std::vector<std::shared_ptr<PoolTap>> taps;
  {
    absl::MutexLock lock(&taps_mutex_);
    taps.swap(taps_);
    taps_end_.Update(reason);
    is_tapped_ = false;
  }
  for (const std::shared_ptr<PoolTap>& tap : taps) {
    tap->OnEnd(reason);
  }
}

void PoolSession::TellTaps(const Request& request, Part part, const Batch& batch, bool ok) {
  if (!is_tapped_) {
    return;
  }
  const bool is_last = part.first + part.count == request.first + request.count;
  absl::MutexLock lock(&taps_mutex_);
  for (const std::shared_ptr<PoolTap>& tap : taps_) {
    if (!ok) {
      tap->OnUnseen();
      continue;
    }
    tap->OnPart(part, batch.observations);
    if (is_last) {
      tap->OnRequestEnd(next_sequence_number_ - 1, change_number_);
    }
  }
}

void PoolSession::TellTapsOfStates() {
  if (!is_tapped_) {
    return;
  }
  absl::MutexLock lock(&taps_mutex_);
  for (const std::shared_ptr<PoolTap>& tap : taps_) {
    tap->OnUnseen();
  }
}

}  // namespace procgen
