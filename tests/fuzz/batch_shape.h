#ifndef TESTS_FUZZ_BATCH_SHAPE_H_
#define TESTS_FUZZ_BATCH_SHAPE_H_

#include <cstddef>
#include <cstdint>

namespace procgen {

// The pool of batch_fuzz, observation_fuzz and their seed inputs: small, so that inputs are.
inline constexpr int32_t kFuzzedEnvCount = 3;
inline constexpr size_t kFuzzedObservationBytes = 16 * 16 * 3;

}  // namespace procgen

#endif  // TESTS_FUZZ_BATCH_SHAPE_H_
