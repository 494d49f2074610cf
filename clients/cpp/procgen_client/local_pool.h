#ifndef PROCGEN_CLIENT_LOCAL_POOL_H_
#define PROCGEN_CLIENT_LOCAL_POOL_H_

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "procgen_client/pool.h"

namespace procgen_client {

// A pool in this process. Requests that wait are stepped by its threads; without threads they are
// stepped by Receive, on the calling thread.
class LocalPool final : public Pool {
 public:
  // `thread_count`: threads beside the caller; absent: one for each further core that the process
  // can use, and fewer than there are environments. Errors: those of procgen::Pool::Create.
  static procgen::StatusOr<std::unique_ptr<LocalPool>> Create(const procgen::PoolOptions& options,
                                                              std::optional<int32_t> thread_count);
  // Waits for the request that is being executed; those behind it are dropped.
  ~LocalPool() override;

  const std::string& name() const override { return name_; }
  const procgen::PoolOptions& options() const override { return pool_->options(); }
  int32_t thread_count() const override { return workers_->thread_count(); }

  procgen::Status Send(const procgen::StepInput& input, absl::Span<const Annotation> annotations,
                       const procgen::Batch& batch) override;
  procgen::Status Receive(std::chrono::duration<double> timeout) override;
  int32_t unanswered_count() const override { return unanswered_count_; }
  procgen::Status Step(const procgen::StepInput& input, absl::Span<const Annotation> annotations,
                       const procgen::Batch& batch) override;

  procgen::Status SetLevelSampler(
      std::shared_ptr<const procgen::LevelSampler> level_sampler) override;
  procgen::StatusOr<std::vector<std::string>> SaveStates(
      absl::Span<const int32_t> environments) override;
  procgen::Status RestoreStates(absl::Span<const procgen::StateToRestore> states) override;
  procgen::Status CloneStates(absl::Span<const procgen::StateToClone> pairs) override;
  procgen::Status Render(int32_t environment, int32_t size_px, bool whole_level,
                         absl::Span<uint8_t> frame) override;
  procgen::Status ReadObjects(int32_t first, int32_t count, int32_t objects_max,
                              absl::Span<procgen::ObjectRow> rows,
                              absl::Span<int32_t> counts) override;

 private:
  // A request with the arrays that it refers to.
  struct Request {
    Request(const procgen::StepInput& input, const procgen::Batch& batch);

    std::vector<int32_t> actions;
    std::vector<procgen::NextLevel> next_levels;
    std::vector<procgen::Reset> resets;
    std::vector<uint8_t> ends;
    procgen::StepInput input;  // its spans are of the arrays above
    procgen::Batch batch;
  };

  LocalPool(std::unique_ptr<procgen::Pool> pool, std::shared_ptr<procgen::WorkerPool> workers);

  // Gives a request to the threads.
  void Begin(Request* request);
  // Stores the result of the request that was executed, and begins the next one.
  void End(procgen::Status result);

  const std::string name_;
  const std::shared_ptr<procgen::WorkerPool> workers_;
  const std::unique_ptr<procgen::Pool> pool_;
  std::vector<uint8_t> ends_;                  // those of Step
  std::atomic<int32_t> unanswered_count_ = 0;  // sent, and not received

  std::mutex mutex_;
  std::condition_variable has_ended_;
  // Under mutex_. The first of `waiting_` is being executed, unless there are no threads.
  std::deque<std::unique_ptr<Request>> waiting_;
  std::deque<procgen::Status> results_;   // of the requests before those
  std::atomic<bool> has_result_ = false;  // results_ is not empty; to poll before locking
};

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_LOCAL_POOL_H_
