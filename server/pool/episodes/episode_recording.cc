#include "server/pool/episodes/episode_recording.h"

#include <cstring>

namespace procgen {
namespace {

template <typename Value>
Value ValueAt(const uint8_t* record) {
  Value value;
  std::memcpy(&value, record + 1, sizeof(value));
  return value;
}

}  // namespace

size_t EpisodeRecording::RecordSize(uint8_t kind) {
  switch (kind) {
    case kCount:
      return 1 + sizeof(uint16_t);
    case kReward:
    case kLevel:
      return 1 + sizeof(uint32_t);
    default:
      return 1;
  }
}

void EpisodeRecording::Reallocate(int64_t capacity) {
  std::vector<uint8_t> moved;
  moved.reserve(static_cast<size_t>(capacity));
  moved.insert(moved.end(), bytes_.begin(), bytes_.end());
  bytes_.swap(moved);
}

bool EpisodeRecording::KeepLast(int64_t bytes) {
  const auto size = static_cast<int64_t>(bytes_.size());
  if (size <= bytes) {
    return false;
  }
  const size_t first = FindStep(static_cast<size_t>(size - bytes));
  bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(first));
  step_count_ = static_cast<int32_t>(Decode().rewards.size());
  annotations.Clear();
  return true;
}

size_t EpisodeRecording::FindStep(size_t from) const {
  bool in_step = false;  // a count was read; its action follows
  size_t at = 0;
  while (at < bytes_.size()) {
    const uint8_t kind = bytes_[at];
    const bool begins_step = !in_step && kind != kReward && kind != kLevel;
    if (begins_step && at >= from) {
      return at;
    }
    in_step = kind == kCount;
    at += RecordSize(kind);
  }
  return at;
}

Episode EpisodeRecording::Decode() const {
  Episode episode;
  static_cast<EpisodeSummary&>(episode) = summary;
  episode.annotations = annotations.Read();
  bool repeats = false;
  uint16_t count = 1;
  for (size_t at = 0; at < bytes_.size(); at += RecordSize(bytes_[at])) {
    const uint8_t* const record = &bytes_[at];
    switch (*record) {
      case kCount:
        count = ValueAt<uint16_t>(record);
        repeats = true;
        break;
      case kReward:
        episode.rewards.back() = ValueAt<float>(record);
        break;
      case kLevel:
        episode.level_changes.push_back(
            {static_cast<int32_t>(episode.actions.size()) - 1, ValueAt<int32_t>(record)});
        break;
      default:
        episode.actions.append(count, static_cast<char>(*record));
        episode.rewards.push_back(0);
        episode.action_counts.push_back(count);
        count = 1;
    }
  }
  if (!repeats) {
    episode.action_counts.clear();
  }
  return episode;
}

}  // namespace procgen
