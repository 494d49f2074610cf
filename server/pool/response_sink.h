#ifndef SERVER_POOL_RESPONSE_SINK_H_
#define SERVER_POOL_RESPONSE_SINK_H_

#include "absl/status/status.h"
#include "envcore/pool/pool.h"

namespace procgen {

// Receives the results of a request from a PoolSession: Prepare, if the request is valid, then
// Done. Threads: one call at a time, from any thread. None may block.
class ResponseSink {
 public:
  virtual ~ResponseSink() = default;

  // Returns the memory for the values of the request, valid until Done. An empty batch: the values
  // are dropped.
  virtual Batch Prepare() = 0;
  // The request and its turn have ended. After an error it has changed nothing.
  virtual void Done(const absl::Status& status) = 0;
};

}  // namespace procgen

#endif  // SERVER_POOL_RESPONSE_SINK_H_
