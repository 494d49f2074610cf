#ifndef SERVER_SESSION_POOL_POOL_OBSERVER_H_
#define SERVER_SESSION_POOL_POOL_OBSERVER_H_

#include <cstdint>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "server/session/backend/request.h"

namespace procgen {

// Receives what is drawn for a pool's learner.
// Threads: one call at a time; OnEnd at any time. No method may call the pool or block: the learner
// waits for all of them except OnEnd.
class PoolObserver {
 public:
  virtual ~PoolObserver() = default;

  // A part of a request was executed. `observations`: the current ones of its environments, in the
  // pool's ObservationFormat; empty if the request asked for none.
  virtual void OnPart(Part part, absl::Span<const uint8_t> observations) = 0;
  // The last part of request `sequence_number` was executed. `change_number`: the pool's new one.
  virtual void OnRequestEnd(int64_t sequence_number, int64_t change_number) = 0;
  // Environments changed without being observed.
  virtual void OnInvalidated() = 0;
  // The pool closed, or observation ends. This is the last call.
  virtual void OnEnd(const absl::Status& reason) = 0;
};

}  // namespace procgen

#endif  // SERVER_SESSION_POOL_POOL_OBSERVER_H_
