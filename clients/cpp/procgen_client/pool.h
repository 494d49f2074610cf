#ifndef PROCGEN_CLIENT_POOL_H_
#define PROCGEN_CLIENT_POOL_H_

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <memory>
#include <numeric>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "envcore/environment/level_sampler.h"
#include "envcore/pool/pool.h"
#include "envcore/status/status.h"

namespace procgen_client {

// Values of a learner for a step, such as its value estimate, shown to viewers of a pool on a
// server (procgen.v1.Annotation).
struct Annotation {
  absl::string_view name;
  absl::Span<const float> values;  // [n, k], for the n environments of the step
};

// A pool of environments, wherever it runs. Requests are executed and answered in order, each once.
// Threads: one at a time.
class Pool {
 public:
  virtual ~Pool() = default;
  Pool(const Pool&) = delete;
  Pool& operator=(const Pool&) = delete;

  // "pools/7" on a server; empty in this process.
  virtual const std::string& name() const = 0;
  // Every default is filled in.
  virtual const procgen::PoolOptions& options() const = 0;
  // Threads that step beside the caller.
  virtual int32_t thread_count() const { return 0; }

  // Begins a request, which is copied. The spans of `batch` must stay valid until Receive has
  // answered it. A request with `steps` false and without resets observes. `annotations`: of a
  // step; ignored by a pool in this process. Fingerprints are 0 in rows without an episode's end.
  // Errors: INVALID_ARGUMENT, FAILED_PRECONDITION too many are unanswered: nothing was sent.
  virtual procgen::Status Send(const procgen::StepInput& input,
                               absl::Span<const Annotation> annotations,
                               const procgen::Batch& batch) = 0;
  // Waits for the oldest unanswered request, and returns its result. A negative timeout has no end.
  // Errors: DEADLINE_EXCEEDED not done yet; FAILED_PRECONDITION nothing is unanswered; those of
  // procgen::Pool::Step.
  virtual procgen::Status Receive(std::chrono::duration<double> timeout) = 0;
  virtual int32_t unanswered_count() const = 0;

  // Send and Receive in one. Errors: FAILED_PRECONDITION a request is unanswered.
  virtual procgen::Status Step(const procgen::StepInput& input,
                               absl::Span<const Annotation> annotations,
                               const procgen::Batch& batch) {
    procgen::Status status = CheckIdle();
    if (status.ok()) {
      status = Send(input, annotations, batch);
    }
    return status.ok() ? Receive(std::chrono::duration<double>(-1)) : status;
  }

  // As those of procgen::Pool. Errors also: FAILED_PRECONDITION a request is unanswered.
  virtual procgen::Status SetLevelSampler(
      std::shared_ptr<const procgen::LevelSampler> level_sampler) = 0;
  virtual procgen::StatusOr<std::vector<std::string>> SaveStates(
      absl::Span<const int32_t> environments) = 0;
  virtual procgen::Status RestoreStates(absl::Span<const procgen::StateToRestore> states) = 0;
  virtual procgen::Status CloneStates(absl::Span<const procgen::StateToClone> pairs) = 0;
  // `frame`: uint8 [size_px, size_px, 3]. `whole_level`: not only what a person sees of it.
  virtual procgen::Status Render(int32_t environment, int32_t size_px, bool whole_level,
                                 absl::Span<uint8_t> frame) = 0;

  // As procgen::Pool::ReadObjects. A pool on a server sends snapshots for it.
  virtual procgen::Status ReadObjects(int32_t first, int32_t count, int32_t objects_max,
                                      absl::Span<procgen::ObjectRow> rows,
                                      absl::Span<int32_t> counts) {
    std::vector<int32_t> environments(static_cast<size_t>(std::max(count, 0)));
    std::iota(environments.begin(), environments.end(), first);
    const auto snapshots = SaveStates(environments);
    return snapshots.ok() ? procgen::ReadObjectsOf(*snapshots, objects_max, rows, counts)
                          : snapshots.status();
  }

 protected:
  Pool() = default;

  // FAILED_PRECONDITION a request is unanswered.
  procgen::Status CheckIdle() const {
    if (unanswered_count() > 0) {
      return procgen::FailedPreconditionError(
          absl::StrCat(unanswered_count(), " requests are unanswered: receive them first"));
    }
    return procgen::OkStatus();
  }
  // FAILED_PRECONDITION too many requests are unanswered, for a pool on servers.
  procgen::Status CheckRoom() const {
    constexpr int32_t kUnansweredMax = 16;
    if (unanswered_count() >= kUnansweredMax) {
      return procgen::FailedPreconditionError(
          absl::StrCat(unanswered_count(), " requests are unanswered, at most ", kUnansweredMax,
                       " can be: receive one first"));
    }
    return procgen::OkStatus();
  }
};

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_POOL_H_
