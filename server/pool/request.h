#ifndef SERVER_POOL_REQUEST_H_
#define SERVER_POOL_REQUEST_H_

#include <cstdint>
#include <memory>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "absl/types/span.h"
#include "envcore/pool/pool.h"
#include "server/pool/episodes/annotation.h"

namespace procgen {

// A stream's request to its pool, in domain types. The spans must stay valid until it is answered.
struct Request {
  enum class Kind : uint8_t {
    kStep,     // steps the slice
    kReset,    // begins new episodes in the environments of `resets`, then observes the slice
    kObserve,  // returns the current state of the slice
    kSample,   // sets `level_sampler` as the level sampler of the whole pool
  };

  Kind kind = Kind::kObserve;
  int32_t first = 0;                         // the slice: environments [first, first + count)
  int32_t count = 0;                         // at least 1, but for kSample
  absl::Span<const int32_t> actions;         // kStep: [count]
  int32_t repeat = 1;                        // kStep: how often each action is taken
  absl::Span<const NextLevel> next_levels;   // kStep
  absl::Span<const Reset> resets;            // kStep, kReset
  absl::Span<const Annotation> annotations;  // kStep; ignored by the pool
  std::shared_ptr<const LevelSampler> level_sampler;  // kSample
  bool with_observations = true;                      // the answer has observations
  bool with_final_observations = false;               // kStep: also those of ended episodes
  bool acknowledge_only = false;                      // kStep, kReset: the answer has no values
  absl::Time arrival_time;                            // on the steady clock
};

// Checks `request` against a pool of `env_count` environments named `pool`.
// Errors: INVALID_ARGUMENT; the message gives the value and the allowed values.
absl::Status CheckRequest(absl::string_view pool, int32_t env_count, const Request& request);

}  // namespace procgen

#endif  // SERVER_POOL_REQUEST_H_
