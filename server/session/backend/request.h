#ifndef SERVER_SESSION_BACKEND_REQUEST_H_
#define SERVER_SESSION_BACKEND_REQUEST_H_

#include <cstdint>
#include <memory>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "absl/types/span.h"
#include "envcore/pool/pool.h"
#include "server/session/backend/annotation.h"

namespace procgen {

// A stream's request to its pool, in domain types. The spans must stay valid until it is answered.
struct Request {
  enum class Kind : uint8_t {
    kStep,     // steps the slice
    kReset,    // begins new episodes in the environments of `resets`, then observes the slice
    kObserve,  // returns the current state of the slice
    kSample,   // sets `level_sampler` as the level sampler of the whole pool
  };

  int64_t sequence_number = 0;         // 0: not from a stream
  int64_t acknowledged = 0;            // answers up to this number have arrived; 0: none given
  absl::Span<const int32_t> released;  // shared-memory batches that the learner no longer needs
  Kind kind = Kind::kObserve;
  int32_t first = 0;                         // the slice: environments [first, first + count)
  int32_t count = 0;                         // 0: all from `first` on
  absl::Span<const int32_t> actions;         // kStep: [count]
  int32_t repeat = 1;                        // kStep: how often each action is taken
  absl::Span<const NextLevel> next_levels;   // kStep
  absl::Span<const Reset> resets;            // kStep, kReset
  absl::Span<const Annotation> annotations;  // kStep; ignored by the pool
  std::shared_ptr<const LevelSampler> level_sampler;  // kSample
  bool with_observations = true;                      // the answer has observations
  bool with_final_observations = false;               // kStep: also those of ended episodes
  int32_t chunk_count = 1;                            // minimum number of parts of the answer
  int32_t chunk_rows_max = INT32_MAX;                 // maximum environments of one part
  absl::Time arrival_time;                            // on the steady clock
  // An earlier process accepted it; it is executed again to reproduce its answer.
  bool again = false;
  // The shared-memory batch to write to; -1: none. Set by PoolSession.
  int32_t shared_batch = -1;
};

// A contiguous part of a request's slice: environments [first, first + count) of the pool.
struct Part {
  int32_t first = 0;
  int32_t count = 0;
};

// Checks `request` against a pool of `env_count` environments named `pool`, and fills in
// `request->count` (kSample: stays 0). Errors: INVALID_ARGUMENT; the message gives the value and
// the allowed values.
absl::Status CheckRequest(absl::string_view pool, int32_t env_count, Request* request);

}  // namespace procgen

#endif  // SERVER_SESSION_BACKEND_REQUEST_H_
