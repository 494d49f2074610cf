#ifndef SERVER_RPC_AUTH_ANONYMOUS_CALL_H_
#define SERVER_RPC_AUTH_ANONYMOUS_CALL_H_

#include <string>
#include <utility>

#include "server/net/connections.h"

namespace procgen {

// A call without a token in progress on a connection. It counts as refused unless it is answered.
// Movable; a moved-from one counts nothing.
class AnonymousCall {
 public:
  // `connections` must outlive this, and has begun the call.
  AnonymousCall(Connections* connections, std::string peer)
      : connections_(connections), peer_(std::move(peer)) {}
  AnonymousCall(AnonymousCall&& other) noexcept
      : connections_(std::exchange(other.connections_, nullptr)),
        peer_(std::move(other.peer_)),
        is_answered_(other.is_answered_) {}
  AnonymousCall& operator=(AnonymousCall&&) = delete;
  ~AnonymousCall() {
    if (connections_ != nullptr) {
      connections_->EndCall(peer_, is_answered_);
    }
  }

  void MarkAnswered() { is_answered_ = true; }

 private:
  Connections* connections_;
  std::string peer_;
  bool is_answered_ = false;
};

}  // namespace procgen

#endif  // SERVER_RPC_AUTH_ANONYMOUS_CALL_H_
