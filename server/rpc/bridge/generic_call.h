#ifndef SERVER_RPC_BRIDGE_GENERIC_CALL_H_
#define SERVER_RPC_BRIDGE_GENERIC_CALL_H_

#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace procgen {

// How a call ended.
struct CallEnd {
  absl::Status status;
  bool is_draining = false;  // trailing metadata "procgen-drains"
};

// Receives what happens in a call. Called on gRPC's threads, OnMessage and OnWritten possibly at
// the same time. Must not block.
class GenericCallObserver {
 public:
  virtual ~GenericCallObserver() = default;

  // Answers a Read.
  virtual void OnMessage(std::string message) = 0;
  // Answers a Write: the next one may follow.
  virtual void OnWritten() = 0;
  // The call has ended. Nothing follows, and the observer is released.
  virtual void OnEnd(const CallEnd& end) = 0;
};

// A call of any method, with serialised messages. The call, not its handle, ends it: by Cancel, or
// by the server. Its end is noticed by a Read. Threads: one at a time. No method blocks.
class GenericCall {
 public:
  virtual ~GenericCall() = default;

  // Requests the next message. REQUIRES: no other Read is unanswered.
  virtual void Read() = 0;
  // Sends a message. REQUIRES: no other Write is unanswered, and HalfClose was not called.
  virtual void Write(const std::string& message) = 0;
  // Sends no further messages. REQUIRES: no Write is unanswered.
  virtual void HalfClose() = 0;
  // Ends the call. The observer then gets at most one more message, and the end.
  virtual void Cancel() = 0;
};

// Starts calls of one server. Threads: any method from any thread.
class GenericStub {
 public:
  // Waits until all calls have ended. The caller cancels them.
  virtual ~GenericStub() = default;

  // Starts a call of `method`, "/PACKAGE.SERVICE/METHOD". `token`: of the caller; empty: none.
  // Errors: INVALID_ARGUMENT the method or the token cannot be sent.
  virtual absl::StatusOr<std::shared_ptr<GenericCall>> Start(
      const std::string& method, const std::string& token,
      std::shared_ptr<GenericCallObserver> observer) = 0;
};

}  // namespace procgen

#endif  // SERVER_RPC_BRIDGE_GENERIC_CALL_H_
