#ifndef TESTS_SERVICE_STREAM_BATCH_COPY_H_
#define TESTS_SERVICE_STREAM_BATCH_COPY_H_

#include <cstdint>
#include <string>
#include <vector>

#include "procgen_client/batch.h"

namespace procgen {

// A copy of all arrays of a batch.
struct BatchCopy {
  explicit BatchCopy(const procgen_client::Batch& batch)
      : observations(batch.observations().begin(), batch.observations().end()),
        final_observations(batch.final_observations().begin(), batch.final_observations().end()),
        rewards(batch.rewards().begin(), batch.rewards().end()),
        first(batch.first().begin(), batch.first().end()),
        terminated(batch.terminated().begin(), batch.terminated().end()),
        truncated(batch.truncated().begin(), batch.truncated().end()),
        level_seeds(batch.level_seeds().begin(), batch.level_seeds().end()),
        prev_level_seeds(batch.prev_level_seeds().begin(), batch.prev_level_seeds().end()),
        prev_level_complete(batch.prev_level_complete().begin(), batch.prev_level_complete().end()),
        episode_returns(batch.episode_returns().begin(), batch.episode_returns().end()),
        episode_lengths(batch.episode_lengths().begin(), batch.episode_lengths().end()),
        fingerprints(batch.fingerprints().begin(), batch.fingerprints().end()) {}

  bool operator==(const BatchCopy& other) const = default;

  std::vector<uint8_t> observations;
  std::vector<uint8_t> final_observations;
  std::vector<float> rewards;
  std::vector<bool> first;
  std::vector<bool> terminated;
  std::vector<bool> truncated;
  std::vector<int32_t> level_seeds;
  std::vector<int32_t> prev_level_seeds;
  std::vector<bool> prev_level_complete;
  std::vector<float> episode_returns;
  std::vector<int32_t> episode_lengths;
  std::vector<uint64_t> fingerprints;
};

}  // namespace procgen

#endif  // TESTS_SERVICE_STREAM_BATCH_COPY_H_
