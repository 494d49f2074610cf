#ifndef SERVER_SESSION_BACKEND_REQUEST_H_
#define SERVER_SESSION_BACKEND_REQUEST_H_

#include <cstdint>
#include <memory>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "absl/types/span.h"
#include "envcore/pool/pool.h"

namespace procgen {

// What a stream asks of its pool, in domain types. The spans must stay valid until it is answered.
struct Request {
  enum class Kind : uint8_t {
    kStep,     // steps the slice
    kReset,    // begins new episodes in the environments of `resets`, then tells how the slice is
    kObserve,  // tells how the slice stands
    kSample,   // has `level_sampler` choose levels from now on, in the whole pool
  };

  int64_t sequence_number = 0;         // 0: of no stream
  int64_t acknowledged = 0;            // answers up to this number have arrived; 0: says nothing
  absl::Span<const int32_t> released;  // batches of shared memory that the learner has done with
  Kind kind = Kind::kObserve;
  int32_t first = 0;                        // the slice: environments [first, first + count)
  int32_t count = 0;                        // 0: all from `first` on
  absl::Span<const int32_t> actions;        // kStep: [count]
  int32_t repeat = 1;                       // kStep: times that the actions are taken
  absl::Span<const NextLevel> next_levels;  // kStep
  absl::Span<const Reset> resets;           // kStep, kReset
  std::shared_ptr<const LevelSampler> level_sampler;  // kSample
  bool with_observations = true;                      // the answer has observations
  bool with_final_observations = false;               // kStep: and those of episodes that end
  int32_t chunk_count = 1;                            // parts of the answer, at least
  int32_t chunk_rows_max = INT32_MAX;                 // environments of one part, at most
  absl::Time arrival_time;                            // by the steady clock
  // It was accepted by an earlier process, and is executed again for the sake of its answer.
  bool again = false;
  // Filled in by PoolSession: the batch of shared memory that is written; -1: none.
  int32_t shared_batch = -1;
};

// A contiguous part of a request's slice: environments [first, first + count) of the pool.
struct Part {
  int32_t first = 0;
  int32_t count = 0;
};

// Checks `request` against a pool of `env_count` environments named `pool`, and fills in
// `request->count`; of kSample it stays 0. Errors: INVALID_ARGUMENT (the message says what was
// given and what is allowed).
absl::Status CheckRequest(absl::string_view pool, int32_t env_count, Request* request);

}  // namespace procgen

#endif  // SERVER_SESSION_BACKEND_REQUEST_H_
