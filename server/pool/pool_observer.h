#ifndef SERVER_POOL_POOL_OBSERVER_H_
#define SERVER_POOL_POOL_OBSERVER_H_

#include <cstdint>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "envcore/pool/pool.h"
#include "server/pool/request.h"

namespace procgen {

// Receives what is drawn for a pool's learner.
// Threads: one call at a time; OnEnd at any time. No method may call the pool or block: the learner
// waits for all of them except OnEnd.
class PoolObserver {
 public:
  virtual ~PoolObserver() = default;

  // The environments whose last scenes it needs when episodes end. Constant.
  virtual absl::Span<const int32_t> final_scene_environments() const { return {}; }

  // `request`, given by `input`, was executed, as the pool's number `request_count`. `batch`: its
  // results. Observations are in the pool's ObservationFormat, and empty if the request asked for
  // none. Other arrays are complete after a step or reset. `final_scenes` contains those of all
  // observers. `change_number`: the pool's new one.
  virtual void OnExecuted(const Request& request, const StepInput& input, const Batch& batch,
                          int64_t request_count, int64_t change_number) = 0;
  // Environments changed without being observed.
  virtual void OnInvalidated() = 0;
  // The pool closed, or observation ends. This is the last call.
  virtual void OnEnd(const absl::Status& reason) = 0;
};

}  // namespace procgen

#endif  // SERVER_POOL_POOL_OBSERVER_H_
