#ifndef CLIENTS_LIBENV_LOCAL_ENVIRONMENTS_H_
#define CLIENTS_LIBENV_LOCAL_ENVIRONMENTS_H_

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "clients/libenv/environments.h"
#include "envcore/pool/batch_numbers.h"
#include "envcore/pool/pool.h"

namespace procgen {

// Environments in this process: a pool with its own worker pool, because handles share nothing.
// With worker threads Act returns at once, so that the host can work meanwhile.
class LocalEnvironments final : public Environments {
 public:
  // `num_threads`: at least 0; 0: the calling thread steps. At most one thread for each environment
  // is started. Errors: those of Pool::Create.
  static absl::StatusOr<std::unique_ptr<LocalEnvironments>> Create(const PoolOptions& options,
                                                                   int32_t num_threads);
  ~LocalEnvironments() override;
  LocalEnvironments(const LocalEnvironments&) = delete;
  LocalEnvironments& operator=(const LocalEnvironments&) = delete;

  absl::Status Act(absl::Span<const int32_t> actions) override;
  absl::StatusOr<EnvironmentValues> Observe() override;
  absl::Status Render(int32_t environment, absl::Span<uint8_t> frame) override;
  absl::StatusOr<std::string> SaveState(int32_t environment) override;
  absl::Status RestoreState(int32_t environment, absl::string_view snapshot) override;

 private:
  LocalEnvironments(std::unique_ptr<Pool> pool, bool has_workers);

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

#endif  // CLIENTS_LIBENV_LOCAL_ENVIRONMENTS_H_
