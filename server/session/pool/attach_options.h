#ifndef SERVER_SESSION_POOL_ATTACH_OPTIONS_H_
#define SERVER_SESSION_POOL_ATTACH_OPTIONS_H_

#include <cstdint>
#include <vector>

#include "server/session/quota/limits.h"

namespace procgen {

// How a stream wants a pool.
struct AttachOptions {
  int32_t requests_in_flight_max = kRequestsInFlightDefault;  // it has no more unanswered
  bool resumable = false;  // the answers to that many are kept, also beyond its end
  bool take_over = false;  // if another stream has the pool, it ends
  // What the caller can do if another stream has the pool, for the error.
  const char* when_attached = "end that one, or attach with take_over";
  // Of a pool that shares memory: how many batches its learner may hold besides those of unanswered
  // requests, and which ones of earlier streams it still holds.
  int32_t held_batches_max = 0;
  std::vector<int32_t> held_batches = {};

  // How many answers are kept.
  int32_t kept_answer_count() const { return resumable ? requests_in_flight_max : 0; }
};

}  // namespace procgen

#endif  // SERVER_SESSION_POOL_ATTACH_OPTIONS_H_
