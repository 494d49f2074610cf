#include "server/session/episodes/recent_episodes.h"

#include <algorithm>

namespace procgen {

void RecentEpisodes::Add(float episode_return, int32_t length) {
  absl::MutexLock lock(&mutex_);
  const size_t place = static_cast<size_t>(count_) % kRecentCount;
  returns_[place] = episode_return;
  lengths_[place] = length;
  ++count_;
}

RecentEpisodes::Summary RecentEpisodes::Read() const {
  absl::MutexLock lock(&mutex_);
  const size_t recent = std::min(static_cast<size_t>(count_), kRecentCount);
  double return_sum = 0;
  double length_sum = 0;
  for (size_t i = 0; i < recent; ++i) {
    return_sum += static_cast<double>(returns_[i]);
    length_sum += lengths_[i];
  }
  const double divisor = std::max(static_cast<double>(recent), 1.0);
  return {count_, static_cast<float>(return_sum / divisor),
          static_cast<float>(length_sum / divisor)};
}

}  // namespace procgen
