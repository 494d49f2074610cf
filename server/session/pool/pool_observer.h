#ifndef SERVER_SESSION_POOL_POOL_OBSERVER_H_
#define SERVER_SESSION_POOL_POOL_OBSERVER_H_

#include <cstdint>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "server/session/backend/request.h"

namespace procgen {

// Somebody who looks at what is drawn for a pool's learner, where it is drawn anyway.
// Threads: one call at a time, but OnEnd at any time. None may call the pool, or block: but for
// OnEnd the learner waits for it.
class PoolObserver {
 public:
  virtual ~PoolObserver() = default;

  // A part of a request was carried out. `observations`: of its environments as they stand now, in
  // the pool's ObservationFormat; empty: nobody asked for them.
  virtual void OnPart(Part part, absl::Span<const uint8_t> observations) = 0;
  // The last part of request `sequence_number` was, and the pool's change number is now this one.
  virtual void OnRequestEnd(int64_t sequence_number, int64_t change_number) = 0;
  // Environments stand where nobody has seen them.
  virtual void OnInvalidated() = 0;
  // The pool is closed, or looking at it ends. Nothing else follows.
  virtual void OnEnd(const absl::Status& reason) = 0;
};

}  // namespace procgen

#endif  // SERVER_SESSION_POOL_POOL_OBSERVER_H_
