#include "server/shared_memory/shared_layout.h"

#include <cstddef>

namespace procgen {
namespace {

using Element = SharedArray::Element;

// As documented in step.proto.
constexpr int64_t kArrayAlignment = 64;
constexpr int64_t kBatchAlignment = 4096;

// The arrays in memory order, which `Rows` relies on.
enum Field : uint8_t {
  kObservations,
  kFinalObservations,
  kFingerprints,
  kRewards,
  kEpisodeReturns,
  kLevelSeeds,
  kPrevLevelSeeds,
  kEpisodeLengths,
  kFirst,
  kTerminated,
  kTruncated,
  kPrevLevelComplete,
};

constexpr SharedArray kArrays[] = {
    {"observations", 0, Element::kUint8, true},
    {"final_observations", 0, Element::kUint8, true},
    {"fingerprints", 0, Element::kInt64, false},
    {"rewards", 0, Element::kFloat32, false},
    {"episode_returns", 0, Element::kFloat32, false},
    {"level_seeds", 0, Element::kInt32, false},
    {"prev_level_seeds", 0, Element::kInt32, false},
    {"episode_lengths", 0, Element::kInt32, false},
    {"first", 0, Element::kBool, false},
    {"terminated", 0, Element::kBool, false},
    {"truncated", 0, Element::kBool, false},
    {"prev_level_complete", 0, Element::kBool, false},
};

int64_t ElementBytes(Element element) {
  switch (element) {
    case Element::kUint8:
    case Element::kBool:
      return 1;
    case Element::kInt32:
    case Element::kFloat32:
      return 4;
    case Element::kInt64:
      return 8;
  }
  return 0;
}

int64_t RoundUp(int64_t bytes, int64_t alignment) {
  return (bytes + alignment - 1) / alignment * alignment;
}

template <typename Number>
absl::Span<Number> RowsOf(uint8_t* array, int32_t first, int32_t count) {
  return absl::MakeSpan(reinterpret_cast<Number*>(array) + first, static_cast<size_t>(count));
}

}  // namespace

SharedLayout::SharedLayout(int32_t env_count, int64_t observation_bytes)
    : observation_bytes_(observation_bytes) {
  int64_t end = 0;
  for (SharedArray array : kArrays) {
    array.offset_bytes = RoundUp(end, kArrayAlignment);
    const int64_t row_bytes = array.is_pictures ? observation_bytes : ElementBytes(array.element);
    end = array.offset_bytes + env_count * row_bytes;
    arrays_.push_back(array);
  }
  batch_bytes_ = RoundUp(end, kBatchAlignment);
}

Batch SharedLayout::Rows(uint8_t* memory, int32_t first, int32_t count) const {
  const auto at = [&](Field field) { return memory + arrays_[field].offset_bytes; };
  const auto pictures = [&](Field field) {
    return absl::MakeSpan(at(field) + first * observation_bytes_,
                          static_cast<size_t>(count * observation_bytes_));
  };
  Batch batch;
  batch.observations = pictures(kObservations);
  batch.final_observations = pictures(kFinalObservations);
  batch.fingerprints = RowsOf<uint64_t>(at(kFingerprints), first, count);
  batch.rewards = RowsOf<float>(at(kRewards), first, count);
  batch.episode_returns = RowsOf<float>(at(kEpisodeReturns), first, count);
  batch.level_seeds = RowsOf<int32_t>(at(kLevelSeeds), first, count);
  batch.prev_level_seeds = RowsOf<int32_t>(at(kPrevLevelSeeds), first, count);
  batch.episode_lengths = RowsOf<int32_t>(at(kEpisodeLengths), first, count);
  batch.first = RowsOf<uint8_t>(at(kFirst), first, count);
  batch.terminated = RowsOf<uint8_t>(at(kTerminated), first, count);
  batch.truncated = RowsOf<uint8_t>(at(kTruncated), first, count);
  batch.prev_level_complete = RowsOf<uint8_t>(at(kPrevLevelComplete), first, count);
  return batch;
}

}  // namespace procgen
