#include "server/session/episodes/recent_episodes.h"

#include <algorithm>
#include <cmath>

namespace procgen {

void RecentEpisodes::Add(const EndedEpisode& episode) {
  absl::MutexLock lock(&mutex_);
  if (episodes_.size() < kListedMax) {
    episodes_.push_back(episode);
  } else {
    episodes_[static_cast<size_t>(count_) % kListedMax] = episode;
  }
  ++count_;
}

RecentEpisodes::Summary RecentEpisodes::Read() const {
  absl::MutexLock lock(&mutex_);
  const size_t recent = StatisticsCount();
  double return_sum = 0;
  double length_sum = 0;
  for (size_t i = 0; i < recent; ++i) {
    return_sum += static_cast<double>(Last(i).total_reward);
    length_sum += Last(i).length;
  }
  const double divisor = std::max(static_cast<double>(recent), 1.0);
  return {count_, static_cast<float>(return_sum / divisor),
          static_cast<float>(length_sum / divisor)};
}

RecentEpisodes::ReturnSpread RecentEpisodes::ReadReturnSpread() const {
  absl::MutexLock lock(&mutex_);
  const size_t recent = StatisticsCount();
  if (recent == 0) {
    return {};
  }
  ReturnSpread spread{Last(0).total_reward, Last(0).total_reward, 0};
  double sum = 0;
  double square_sum = 0;
  for (size_t i = 0; i < recent; ++i) {
    const float value = Last(i).total_reward;
    spread.min = std::min(spread.min, value);
    spread.max = std::max(spread.max, value);
    sum += static_cast<double>(value);
    square_sum += static_cast<double>(value) * static_cast<double>(value);
  }
  const auto count = static_cast<double>(recent);
  const double mean = sum / count;
  spread.deviation = static_cast<float>(std::sqrt(std::max(square_sum / count - mean * mean, 0.0)));
  return spread;
}

RecentEpisodes::List RecentEpisodes::ReadList(int64_t after) const {
  absl::MutexLock lock(&mutex_);
  const int64_t wanted = std::clamp<int64_t>(count_ - std::max<int64_t>(after, 0), 0,
                                             static_cast<int64_t>(episodes_.size()));
  List list{count_, {}};
  list.episodes.reserve(static_cast<size_t>(wanted));
  for (auto i = static_cast<size_t>(wanted); i > 0; --i) {
    list.episodes.push_back(Last(i - 1));
  }
  return list;
}

size_t RecentEpisodes::StatisticsCount() const { return std::min(episodes_.size(), kRecentCount); }

const EndedEpisode& RecentEpisodes::Last(size_t i) const {
  return episodes_[(static_cast<size_t>(count_) - 1 - i) % kListedMax];
}

}  // namespace procgen
