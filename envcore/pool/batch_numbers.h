#ifndef ENVCORE_POOL_BATCH_NUMBERS_H_
#define ENVCORE_POOL_BATCH_NUMBERS_H_

#include <cstdint>
#include <vector>

#include "envcore/pool/pool.h"

namespace procgen {

// Buffers for all arrays of a Batch except the observations. Batch documents each array.
struct BatchNumbers {
  std::vector<float> rewards;
  std::vector<uint8_t> first;
  std::vector<uint8_t> terminated;
  std::vector<uint8_t> truncated;
  std::vector<int32_t> level_seeds;
  std::vector<int32_t> prev_level_seeds;
  std::vector<uint8_t> prev_level_complete;
  std::vector<float> episode_returns;
  std::vector<int32_t> episode_lengths;
  std::vector<uint64_t> fingerprints;

  // Returns `batch`, of `count` environments, with each empty array replaced by a buffer of this
  // object. The buffers keep their values between calls. The returned spans are valid until the
  // next call.
  Batch ReplaceEmptyArrays(Batch batch, int32_t count);

  bool operator==(const BatchNumbers& other) const = default;
};

}  // namespace procgen

#endif  // ENVCORE_POOL_BATCH_NUMBERS_H_
