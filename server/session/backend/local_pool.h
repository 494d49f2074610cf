#ifndef SERVER_SESSION_BACKEND_LOCAL_POOL_H_
#define SERVER_SESSION_BACKEND_LOCAL_POOL_H_

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/types/span.h"
#include "envcore/pool/pool.h"
#include "server/concurrency/background_executor.h"
#include "server/session/backend/pool_backend.h"

namespace procgen {

// A pool of this process, stepped by its worker pool. Other long operations run on the background
// executor.
class LocalPool final : public PoolBackend {
 public:
  // `executor` must outlive this. Its work for the pool is accounted to `owner`.
  LocalPool(std::unique_ptr<Pool> pool, std::string owner, BackgroundExecutor* executor);
  ~LocalPool() override;

  const PoolOptions& options() const override { return pool_->options(); }
  bool AwaitsReset(int32_t environment) const override { return pool_->AwaitsReset(environment); }
  void BeginRequest(const Request& /*request*/, const Batch& /*first_part*/) override {}
  void StepAsync(const StepInput& part, const Batch& batch, Done done) override;
  void SetLevelSampler(std::shared_ptr<const LevelSampler> level_sampler, Done done) override;
  void SaveStates(absl::Span<const int32_t> environments, TakeState take, Done done) override;
  void RestoreStates(std::vector<StateToRestore> states, Done done) override;
  void CloneStates(std::vector<StateToClone> pairs, Done done) override;
  void CaptureScenes(const std::vector<int32_t>& environments, View view, int32_t size_px,
                     CaptureDone done) override;

 private:
  class Renderers;

  void CaptureScenesHere(const std::vector<int32_t>& environments, View view, int32_t size_px,
                         CaptureDone done);

  const std::unique_ptr<Pool> pool_;
  const std::string owner_;
  BackgroundExecutor* const executor_;
  const std::shared_ptr<Renderers> renderers_;
};

// Creates pools in this process; they share one worker pool.
class LocalPoolFactory final : public PoolBackendFactory {
 public:
  // `worker_count` >= 1: threads that step environments. `art`: what all pools draw with; null: the
  // built-in art. `executor` must outlive this and its pools.
  LocalPoolFactory(int32_t worker_count, std::shared_ptr<const SharedArt> art,
                   BackgroundExecutor* executor);

  void Create(const CreatePoolOptions& create_options, CreateDone done) override;
  int32_t worker_count() const override { return workers_->thread_count(); }

 private:
  const std::shared_ptr<WorkerPool> workers_;
  const std::shared_ptr<const SharedArt> art_;
  BackgroundExecutor* const executor_;
};

}  // namespace procgen

#endif  // SERVER_SESSION_BACKEND_LOCAL_POOL_H_
