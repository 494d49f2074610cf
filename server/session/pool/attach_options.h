#ifndef SERVER_SESSION_POOL_ATTACH_OPTIONS_H_
#define SERVER_SESSION_POOL_ATTACH_OPTIONS_H_

#include <cstdint>
#include <vector>

#include "server/session/quota/limits.h"

namespace procgen {

// How a stream attaches to a pool.
struct AttachOptions {
  int32_t requests_in_flight_max = kRequestsInFlightDefault;  // maximum unanswered requests
  bool resumable = false;  // keep that many answers, also after the stream ends
  bool take_over = false;  // end another attached stream
  // Advice for the error if another stream is attached.
  const char* when_attached = "end that one, or attach with take_over";
  // For a pool that shares memory: how many batches its learner may hold besides those of
  // unanswered requests, and which batches of earlier streams it still holds.
  int32_t held_batches_max = 0;
  std::vector<int32_t> held_batches = {};

  // Number of answers to keep.
  int32_t kept_answer_count() const { return resumable ? requests_in_flight_max : 0; }
};

}  // namespace procgen

#endif  // SERVER_SESSION_POOL_ATTACH_OPTIONS_H_
