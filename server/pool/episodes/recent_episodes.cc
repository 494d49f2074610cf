#include "server/pool/episodes/recent_episodes.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace procgen {
namespace {

int64_t BytesOf(const EpisodeRecording& recording) {
  return recording.capacity() + static_cast<int64_t>(sizeof(EpisodeRecording));
}

}  // namespace

RecentEpisodes::~RecentEpisodes() { bytes_->Change(reserved_bytes_ + annotation_bytes_, 0); }

void RecentEpisodes::Add(const EndedEpisode& episode, std::optional<EpisodeRecording> recording) {
  absl::MutexLock lock(&mutex_);
  if (recordings_.size() == kListedMax) {
    DropOldestRecording();
  }
  if (recording.has_value() && Reserve(BytesOf(*recording))) {
    recording->annotations.ShrinkToFit();
    if (!ReserveAnnotations(recording->annotations.bytes())) {
      recording->annotations.Clear();
    }
    recordings_.push_back(*std::move(recording));
  } else {
    while (!recordings_.empty()) {
      DropOldestRecording();
    }
  }
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

std::vector<std::optional<float>> RecentEpisodes::ReadMeanReturns(
    size_t count, absl::FunctionRef<size_t(int32_t environment)> group_of) const {
  struct Sum {
    double sum = 0;
    size_t count = 0;
  };
  std::vector<Sum> sums(count);
  {
    absl::MutexLock lock(&mutex_);
    for (size_t i = 0; i < episodes_.size(); ++i) {
      Sum& sum = sums[group_of(Last(i).environment)];
      if (sum.count < kRecentCount) {
        sum.sum += static_cast<double>(Last(i).total_reward);
        ++sum.count;
      }
    }
  }
  std::vector<std::optional<float>> means(count);
  for (size_t group = 0; group < count; ++group) {
    if (sums[group].count > 0) {
      means[group] = static_cast<float>(sums[group].sum / static_cast<double>(sums[group].count));
    }
  }
  return means;
}

RecentEpisodes::List RecentEpisodes::ReadList(int64_t after) const {
  absl::MutexLock lock(&mutex_);
  const int64_t wanted = std::clamp<int64_t>(count_ - std::max<int64_t>(after, 0), 0,
                                             static_cast<int64_t>(episodes_.size()));
  List list{count_, {}, static_cast<int64_t>(recordings_.size())};
  list.episodes.reserve(static_cast<size_t>(wanted));
  for (auto i = static_cast<size_t>(wanted); i > 0; --i) {
    list.episodes.push_back(Last(i - 1));
  }
  return list;
}

std::optional<EpisodeRecording> RecentEpisodes::Find(int32_t environment,
                                                     uint64_t fingerprint) const {
  absl::MutexLock lock(&mutex_);
  for (size_t i = 0; i < recordings_.size(); ++i) {
    if (Last(i).environment == environment && Last(i).fingerprint == fingerprint) {
      return recordings_[recordings_.size() - 1 - i];
    }
  }
  return std::nullopt;
}

bool RecentEpisodes::Reserve(int64_t bytes) {
  // The other half is for the episodes that are being recorded.
  while (reserved_bytes_ + bytes > kRecordingBytesMax ||
         bytes_->reserved_bytes() + bytes > bytes_->bytes_max() / 2 ||
         !bytes_->Change(reserved_bytes_, reserved_bytes_ + bytes)) {
    if (DropOldestAnnotations()) {
      continue;
    }
    if (recordings_.empty()) {
      return false;
    }
    DropOldestRecording();
  }
  reserved_bytes_ += bytes;
  return true;
}

bool RecentEpisodes::ReserveAnnotations(int64_t bytes) {
  while (annotation_bytes_ + bytes > kAnnotationBytesMax ||
         bytes_->reserved_bytes() + bytes > bytes_->bytes_max() / 2 ||
         !bytes_->Change(annotation_bytes_, annotation_bytes_ + bytes)) {
    if (!DropOldestAnnotations()) {
      return false;
    }
  }
  annotation_bytes_ += bytes;
  return true;
}

bool RecentEpisodes::DropOldestAnnotations() {
  constexpr size_t kNone = kListedMax;
  size_t oldest = kNone;
  size_t best = kNone;
  size_t worst = kNone;
  const auto reward_of = [this](size_t i) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return Last(recordings_.size() - 1 - i).total_reward;
  };
  const auto has_annotations = [this](size_t i) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return recordings_[i].annotations.bytes() > 0;
  };
  for (size_t i = 0; i < recordings_.size(); ++i) {
    if (has_annotations(i)) {
      oldest = std::min(oldest, i);
      best = best == kNone || reward_of(i) >= reward_of(best) ? i : best;
      worst = worst == kNone || reward_of(i) <= reward_of(worst) ? i : worst;
    }
  }
  if (oldest == kNone) {
    return false;
  }
  size_t dropped = oldest;
  while (dropped < recordings_.size() &&
         (dropped == best || dropped == worst || !has_annotations(dropped))) {
    ++dropped;
  }
  DropAnnotations(&recordings_[dropped < recordings_.size() ? dropped : oldest]);
  return true;
}

void RecentEpisodes::DropAnnotations(EpisodeRecording* recording) {
  const int64_t left = annotation_bytes_ - recording->annotations.bytes();
  recording->annotations.Clear();
  bytes_->Change(annotation_bytes_, left);
  annotation_bytes_ = left;
}

void RecentEpisodes::DropOldestRecording() {
  DropAnnotations(&recordings_.front());
  const int64_t left = reserved_bytes_ - BytesOf(recordings_.front());
  recordings_.pop_front();
  bytes_->Change(reserved_bytes_, left);
  reserved_bytes_ = left;
}

size_t RecentEpisodes::StatisticsCount() const { return std::min(episodes_.size(), kRecentCount); }

const EndedEpisode& RecentEpisodes::Last(size_t i) const {
  return episodes_[(static_cast<size_t>(count_) - 1 - i) % kListedMax];
}

}  // namespace procgen
