#ifndef SERVER_POOL_EPISODES_EPISODE_RECORDING_H_
#define SERVER_POOL_EPISODES_EPISODE_RECORDING_H_

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "server/pool/episodes/annotation_recording.h"
#include "server/pool/episodes/episode.h"

namespace procgen {

// An episode being recorded: its summary, and its steps in one append buffer.
//
// The buffer is a sequence of records. A step is its action, one byte. A repeat count other than 1
// precedes the action. A reward other than 0 and the seed of a new level follow it.
// Threads: compatible.
class EpisodeRecording {
 public:
  // Memory of the buffer, in bytes, and whether it has room for another step.
  int64_t capacity() const { return static_cast<int64_t>(bytes_.capacity()); }
  bool HasRoom() const { return bytes_.capacity() - bytes_.size() >= kStepBytesMax; }
  // Moves the steps to a buffer of `capacity` bytes. REQUIRES: they fit.
  void Reallocate(int64_t capacity);

  // Adds a step. `count`: how often the action was taken, in [0, 65535]. REQUIRES: HasRoom().
  void AddStep(int32_t action, int32_t count, float reward) {
    if (count != 1) {
      Append(kCount, static_cast<uint16_t>(count));
    }
    ++step_count_;
    bytes_.push_back(static_cast<uint8_t>(action));
    if (std::bit_cast<uint32_t>(reward) != 0) {
      Append(kReward, reward);
    }
  }
  // Records that a level began with the last added step. At most once per step.
  void AddLevel(int32_t level_seed) { Append(kLevel, level_seed); }
  // Number of steps that it has.
  int32_t step_count() const { return step_count_; }
  // Drops all steps and keeps the memory.
  void ClearSteps() {
    bytes_.clear();
    step_count_ = 0;
    annotations.ClearRows();
  }
  // Drops the oldest steps until the rest takes at most `bytes`, and then all annotations. Returns
  // whether any were dropped.
  bool KeepLast(int64_t bytes);

  Episode Decode() const;

  EpisodeSummary summary;
  // Of the steps. Not part of `capacity`.
  AnnotationRecording annotations;

 private:
  static constexpr size_t kStepBytesMax = 14;  // count 3, action 1, reward 5, level 5
  // Kinds of records that are no actions, in their first byte; a value follows.
  static constexpr uint8_t kCount = 0x80;   // uint16
  static constexpr uint8_t kReward = 0x81;  // float
  static constexpr uint8_t kLevel = 0x82;   // int32

  static size_t RecordSize(uint8_t kind);
  template <typename Value>
  void Append(uint8_t kind, Value value) {
    const size_t at = bytes_.size();
    bytes_.resize(at + 1 + sizeof(value));
    bytes_[at] = kind;
    std::memcpy(&bytes_[at + 1], &value, sizeof(value));
  }
  // Returns the start of the first step at or after `from`.
  size_t FindStep(size_t from) const;

  std::vector<uint8_t> bytes_;
  int32_t step_count_ = 0;
};

}  // namespace procgen

#endif  // SERVER_POOL_EPISODES_EPISODE_RECORDING_H_
