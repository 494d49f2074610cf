#ifndef CLIENTS_LIBENV_ENVIRONMENTS_H_
#define CLIENTS_LIBENV_ENVIRONMENTS_H_

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "absl/types/span.h"
#include "envcore/pool/batch_numbers.h"
#include "envcore/pool/pool.h"

namespace procgen {

// Values of N environments. Valid until the next call on the environments.
struct EnvironmentValues {
  absl::Span<const uint8_t> observations;         // [N, 64, 64, 3]
  absl::Span<const float> rewards;                // [N]
  absl::Span<const uint8_t> first;                // [N]
  absl::Span<const int32_t> prev_level_seeds;     // [N]
  absl::Span<const uint8_t> prev_level_complete;  // [N]
  absl::Span<const int32_t> level_seeds;          // [N]
};

// The environments behind a handle: a pool with its own worker pool, because handles share nothing.
// Initially each is at the first step of its first level.
// Threads: compatible (one at a time).
class Environments {
 public:
  // `num_threads`: at least 0; 0: the calling thread steps. At most one thread for each environment
  // is started. Errors: those of Pool::Create.
  static absl::StatusOr<std::unique_ptr<Environments>> Create(const PoolOptions& options,
                                                              int32_t num_threads);
  // Waits for a running step.
  ~Environments();
  Environments(const Environments&) = delete;
  Environments& operator=(const Environments&) = delete;

  // Starts a step, and with worker threads returns at once, so that the host can work meanwhile.
  // `actions`: [N], each in [-1, kActionCount), not used after the call. Errors: those of the
  // previous step, and those of this one that are known already.
  absl::Status Act(absl::Span<const int32_t> actions);

  // Waits for the step and returns its values.
  absl::StatusOr<EnvironmentValues> Observe();

  // Waits for the step and renders the human view of one environment. `frame`: uint8
  // [kHumanViewSizePx, kHumanViewSizePx, 3].
  absl::Status Render(int32_t environment, absl::Span<uint8_t> frame);

  // Waits for the step and returns a snapshot of one environment.
  absl::StatusOr<std::string> SaveState(int32_t environment);

  // Waits for the step and restores a snapshot in one environment; the next Observe returns it. On
  // error nothing has changed. Errors: INVALID_ARGUMENT a snapshot of another game, or with a value
  // out of range; DATA_LOSS a snapshot that is damaged or of another version.
  absl::Status RestoreState(int32_t environment, absl::string_view snapshot);

 private:
  Environments(std::unique_ptr<Pool> pool, bool has_workers);

  // Waits until no step runs; returns the status of the last one.
  absl::Status Wait();
  Batch OwnBatch();

  const std::unique_ptr<Pool> pool_;
  const bool has_workers_;
  std::vector<int32_t> actions_;       // [N] of the running step
  std::vector<uint8_t> observations_;  // [N, 64, 64, 3]
  BatchNumbers numbers_;               // [N]
  absl::Mutex mutex_;
  bool is_stepping_ ABSL_GUARDED_BY(mutex_) = false;
  absl::Status status_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace procgen

#endif  // CLIENTS_LIBENV_ENVIRONMENTS_H_
