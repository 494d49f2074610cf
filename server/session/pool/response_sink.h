#ifndef SERVER_SESSION_POOL_RESPONSE_SINK_H_
#define SERVER_SESSION_POOL_RESPONSE_SINK_H_

#include <optional>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/cord.h"
#include "envcore/pool/pool.h"
#include "server/session/backend/request.h"
#include "server/session/pool/kept_answers.h"

namespace procgen {

// Receives what a PoolSession makes of a request, chunk by chunk.
//
// The order of calls: for each part PreparePart, until it returns a batch, then PartDone; at the
// end Done, once. A request that was executed before has no parts: Recall, then Done.
// Threads: one call at a time, from any thread; only Flush may run at the same time as another
// call, or after it. None may block.
class ResponseSink {
 public:
  virtual ~ResponseSink() = default;

  // Whether the request is still wanted when its turn comes. If not, it ends with CANCELLED.
  virtual bool IsWanted() { return true; }
  // The memory that the values of `part` are written to, valid until PartDone or Done. An empty
  // batch: the part is executed, and its values are dropped. nullopt: no memory is free; the sink
  // calls PoolSession::Resume when some is. Errors end the request; only after the pool has closed.
  virtual absl::StatusOr<std::optional<Batch>> PreparePart(Part part) = 0;
  // The pool has nothing more to do on this thread for now: it executes a part on other threads, or
  // waits for memory. A good moment to send what is ready.
  virtual void Flush() {}
  // The values of the part are written. Returns the response as it is sent, if `keep`: the pool
  // keeps it, so that it can be asked for again. After the last part the request is not used any
  // more.
  virtual absl::Cord PartDone(Part part, bool keep) = 0;
  // The answer to a request that was executed before. Errors end the request.
  virtual absl::Status Recall(const Answer& answer) = 0;
  // The request has ended, and so has its turn, if it had one of its own. On an error it changed
  // nothing, and its sequence number is the next again. The pool may be destroyed from here on,
  // unless the turn is the caller's.
  virtual void Done(const absl::Status& status) = 0;
};

}  // namespace procgen

#endif  // SERVER_SESSION_POOL_RESPONSE_SINK_H_
