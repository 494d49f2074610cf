#include "procgen_client/local_pool.h"

#include <algorithm>
#include <utility>

#include "envcore/pool/cpu_count.h"
#include "envcore/pool/pool_input.h"
#include "envcore/pool/scene_snapshot.h"
#include "envcore/pool/spin_wait.h"

namespace procgen_client {
namespace {

// The batch with `terminated` and `truncated` in `ends` if it has fingerprints but not these.
procgen::Batch WithEnds(procgen::Batch batch, std::vector<uint8_t>* ends) {
  const size_t rows = batch.fingerprints.size();
  ends->resize(2 * rows);
  for (const auto& [array, begin] :
       {std::pair(&batch.terminated, size_t{0}), std::pair(&batch.truncated, rows)}) {
    if (array->empty()) {
      *array = absl::MakeSpan(*ends).subspan(begin, rows);
    }
  }
  return batch;
}

// The engine also writes those of episodes that run; a server does not send them.
procgen::Status WithFingerprintsOfEnds(procgen::Status result, const procgen::Batch& batch) {
  for (size_t row = 0; result.ok() && row < batch.fingerprints.size(); ++row) {
    if (batch.terminated[row] == 0 && batch.truncated[row] == 0) {
      batch.fingerprints[row] = 0;
    }
  }
  return result;
}

}  // namespace

LocalPool::Request::Request(const procgen::StepInput& input, const procgen::Batch& batch)
    : actions(input.actions.begin(), input.actions.end()),
      next_levels(input.next_levels.begin(), input.next_levels.end()),
      resets(input.resets.begin(), input.resets.end()),
      input(input),
      batch(WithEnds(batch, &ends)) {
  this->input.actions = actions;
  this->input.next_levels = next_levels;
  this->input.resets = resets;
}

procgen::StatusOr<std::unique_ptr<LocalPool>> LocalPool::Create(
    const procgen::PoolOptions& options, std::optional<int32_t> thread_count) {
  // The calling thread works, too, and takes at least one environment.
  const int32_t wanted = thread_count.value_or(procgen::CpuCount() - 1);
  auto workers = std::make_shared<procgen::WorkerPool>(
      std::clamp(wanted, 0, std::max(0, options.env_count - 1)));
  auto pool = procgen::Pool::Create(options, workers);
  if (!pool.ok()) {
    return pool.status();
  }
  return std::unique_ptr<LocalPool>(new LocalPool(*std::move(pool), std::move(workers)));
}

LocalPool::LocalPool(std::unique_ptr<procgen::Pool> pool,
                     std::shared_ptr<procgen::WorkerPool> workers)
    : workers_(std::move(workers)), pool_(std::move(pool)) {}

LocalPool::~LocalPool() {
  std::unique_lock lock(mutex_);
  if (thread_count() > 0 && !waiting_.empty()) {
    waiting_.erase(waiting_.begin() + 1, waiting_.end());
    has_ended_.wait(lock, [this] { return waiting_.empty(); });
  }
}

procgen::Status LocalPool::Send(const procgen::StepInput& input,
                                absl::Span<const Annotation> /*annotations*/,
                                const procgen::Batch& batch) {
  if (procgen::Status status =
          procgen::CheckStep(input, batch, options().env_count, pool_->observation_bytes());
      !status.ok()) {
    return status;
  }
  auto owned = std::make_unique<Request>(input, batch);
  Request* const request = owned.get();
  bool begins = false;
  {
    const std::lock_guard lock(mutex_);
    begins = thread_count() > 0 && waiting_.empty();
    waiting_.push_back(std::move(owned));
  }
  ++unanswered_count_;
  if (begins) {
    Begin(request);
  }
  return procgen::OkStatus();
}

void LocalPool::Begin(Request* request) {
  pool_->StepAsync(request->input, request->batch, [this, request](procgen::Status result) {
    End(WithFingerprintsOfEnds(std::move(result), request->batch));
  });
}

void LocalPool::End(procgen::Status result) {
  Request* next = nullptr;
  {
    const std::lock_guard lock(mutex_);
    waiting_.pop_front();
    results_.push_back(std::move(result));
    has_result_.store(true, std::memory_order_release);
    if (!waiting_.empty()) {
      next = waiting_.front().get();
    }
    has_ended_.notify_all();
  }
  if (next != nullptr) {
    Begin(next);
  }
}

procgen::Status LocalPool::Receive(std::chrono::duration<double> timeout) {
  if (unanswered_count_ == 0) {
    return procgen::FailedPreconditionError("no request is unanswered: send one first");
  }
  if (thread_count() == 0) {
    std::unique_ptr<Request> request;
    {
      const std::lock_guard lock(mutex_);
      request = std::move(waiting_.front());
      waiting_.pop_front();
    }
    --unanswered_count_;
    return WithFingerprintsOfEnds(pool_->Step(request->input, request->batch), request->batch);
  }
  procgen::SpinUntil([this] { return has_result_.load(std::memory_order_acquire); });
  std::unique_lock lock(mutex_);
  const auto has_result = [this] { return !results_.empty(); };
  if (timeout < std::chrono::duration<double>::zero()) {
    has_ended_.wait(lock, has_result);
  } else if (!has_ended_.wait_for(lock, timeout, has_result)) {
    return procgen::DeadlineExceededError("the oldest request is not answered yet");
  }
  procgen::Status result = std::move(results_.front());
  results_.pop_front();
  has_result_.store(!results_.empty(), std::memory_order_relaxed);
  --unanswered_count_;
  return result;
}

procgen::Status LocalPool::Step(const procgen::StepInput& input,
                                absl::Span<const Annotation> /*annotations*/,
                                const procgen::Batch& batch) {
  if (procgen::Status status = CheckIdle(); !status.ok()) {
    return status;
  }
  const procgen::Batch with_ends = WithEnds(batch, &ends_);
  return WithFingerprintsOfEnds(pool_->Step(input, with_ends), with_ends);
}

procgen::Status LocalPool::SetLevelSampler(
    std::shared_ptr<const procgen::LevelSampler> level_sampler) {
  if (procgen::Status status = CheckIdle(); !status.ok()) {
    return status;
  }
  return pool_->SetLevelSampler(std::move(level_sampler));
}

procgen::StatusOr<std::vector<std::string>> LocalPool::SaveStates(
    absl::Span<const int32_t> environments) {
  if (procgen::Status status = CheckIdle(); !status.ok()) {
    return status;
  }
  return pool_->SaveStates(environments);
}

procgen::Status LocalPool::RestoreStates(absl::Span<const procgen::StateToRestore> states) {
  if (procgen::Status status = CheckIdle(); !status.ok()) {
    return status;
  }
  return pool_->RestoreStates(states);
}

procgen::Status LocalPool::CloneStates(absl::Span<const procgen::StateToClone> pairs) {
  if (procgen::Status status = CheckIdle(); !status.ok()) {
    return status;
  }
  return pool_->CloneStates(pairs);
}

procgen::Status LocalPool::Render(int32_t environment, int32_t size_px, bool whole_level,
                                  absl::Span<uint8_t> frame) {
  if (procgen::Status status = CheckIdle(); !status.ok()) {
    return status;
  }
  return pool_->Render(environment, size_px, frame, whole_level);
}

procgen::Status LocalPool::ReadObjects(int32_t first, int32_t count, int32_t objects_max,
                                       absl::Span<procgen::ObjectRow> rows,
                                       absl::Span<int32_t> counts) {
  if (procgen::Status status = CheckIdle(); !status.ok()) {
    return status;
  }
  return pool_->ReadObjects(first, count, objects_max, rows, counts);
}

}  // namespace procgen_client
