#ifndef TESTS_ENVCORE_POOL_BATCH_BUFFERS_H_
#define TESTS_ENVCORE_POOL_BATCH_BUFFERS_H_

#include <cstdint>
#include <vector>

#include "absl/types/span.h"
#include "envcore/pool/batch_numbers.h"
#include "envcore/pool/pool.h"

namespace procgen {

// The buffers of a batch of n environments.
struct BatchBuffers : BatchNumbers {
  std::vector<uint8_t> observations;
  std::vector<uint8_t> final_observations;

  size_t observation_bytes = 0;  // of one environment

  explicit BatchBuffers(int32_t env_count, size_t bytes = kObservationBytes)
      : observation_bytes(bytes) {
    const auto n = static_cast<size_t>(env_count);
    ReplaceEmptyArrays({}, env_count);
    observations.resize(n * bytes);
    final_observations.resize(n * bytes);
  }

  Batch Whole() { return Rows(0, static_cast<int32_t>(rewards.size())); }

  // The rows [begin, begin + count).
  Batch Rows(int32_t begin, int32_t count) {
    const auto b = static_cast<size_t>(begin);
    const auto n = static_cast<size_t>(count);
    const size_t pixels = b * observation_bytes;
    const size_t pixel_count = n * observation_bytes;
    Batch batch;
    batch.observations = absl::MakeSpan(observations).subspan(pixels, pixel_count);
#define PROCGEN_ROWS(type, name, member) batch.name = absl::MakeSpan(name).subspan(b, n);
    PROCGEN_BATCH_NUMBERS(PROCGEN_ROWS)
#undef PROCGEN_ROWS
    batch.final_observations = absl::MakeSpan(final_observations).subspan(pixels, pixel_count);
    return batch;
  }

  bool operator==(const BatchBuffers& other) const = default;
};

}  // namespace procgen

#endif  // TESTS_ENVCORE_POOL_BATCH_BUFFERS_H_
