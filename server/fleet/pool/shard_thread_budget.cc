#include "server/fleet/pool/shard_thread_budget.h"

#include <algorithm>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"

namespace procgen {

void ShardThreadBudget::Release::operator()(ShardThreadBudget* budget) const {
  absl::MutexLock lock(&budget->mutex_);
  --budget->reserved_count_;
}

absl::StatusOr<std::vector<ShardThreadBudget::Reservation>> ShardThreadBudget::Reserve(
    size_t count) {
  std::vector<Reservation> reservations;
  absl::MutexLock lock(&mutex_);
  if (reserved_count_ >= thread_count_max_) {
    return absl::ResourceExhaustedError(
        absl::StrCat("the fleet runs ", reserved_count_, " shards, limit ", thread_count_max_,
                     ": delete pools, or make them with fewer environments on another fleet"));
  }
  while (reservations.size() < count && reserved_count_ < thread_count_max_) {
    reservations.emplace_back(this);
    ++reserved_count_;
  }
  return reservations;
}

size_t ShardThreadBudget::available() const {
  absl::MutexLock lock(&mutex_);
  return static_cast<size_t>(std::max(0, thread_count_max_ - reserved_count_));
}

}  // namespace procgen
