#ifndef SERVER_SESSION_POOL_RESPONSE_SINK_H_
#define SERVER_SESSION_POOL_RESPONSE_SINK_H_

#include <optional>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/cord.h"
#include "envcore/pool/pool.h"
#include "server/session/backend/request.h"
#include "server/session/pool/answer_cache.h"

namespace procgen {

// Receives the results of a request from a PoolSession, part by part.
//
// Order of calls: for each part PreparePart, until it returns a batch, then PartDone; at the end
// Done, once. A request that was executed before has no parts: Recall, then Done.
// Threads: one call at a time, from any thread. Flush may also run during or after another call.
// None may block.
class ResponseSink {
 public:
  virtual ~ResponseSink() = default;

  // Whether the request is still wanted when its turn begins. If not, it ends with CANCELLED.
  virtual bool IsWanted() { return true; }
  // Returns the memory for the values of `part`, valid until PartDone or Done. An empty batch: the
  // part is executed and its values are dropped. nullopt: no memory is free; the sink later calls
  // PoolSession::Resume. Errors end the request and are allowed only after the pool has closed.
  virtual absl::StatusOr<std::optional<Batch>> PreparePart(Part part) = 0;
  // The pool has nothing more to do on this thread for now: a part runs on other threads, or memory
  // is missing. The sink can send what is ready.
  virtual void Flush() {}
  // The values of the part are written. If `keep`, returns the response as sent, and the pool keeps
  // it for resuming streams. The request is not used after its last part.
  virtual absl::Cord PartDone(Part part, bool keep) = 0;
  // Sends the answer to a request that was executed before. Errors end the request.
  virtual absl::Status Recall(const Answer& answer) = 0;
  // The request and its own turn, if it had one, have ended. After an error it has changed nothing
  // and its sequence number is the next one again. The pool may be destroyed from here on, unless
  // the turn is the caller's.
  virtual void Done(const absl::Status& status) = 0;
};

}  // namespace procgen

#endif  // SERVER_SESSION_POOL_RESPONSE_SINK_H_
