#ifndef SERVER_RPC_AUTH_CALL_ACCOUNTING_H_
#define SERVER_RPC_AUTH_CALL_ACCOUNTING_H_

#include <cstdint>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "grpcpp/server_context.h"
#include "grpcpp/support/status.h"
#include "server/metrics/metrics.h"
#include "server/net/connections.h"
#include "server/rpc/auth/anonymous_call.h"
#include "server/rpc/auth/authenticator.h"
#include "server/session/quota/quotas.h"

namespace procgen {

// Somebody who may call.
struct Caller {
  std::string owner;  // of the pools that it makes and sees; empty: callers are not asked
  Quotas::Reservation reservation;        // of the calls that the owner may have under way
  std::shared_ptr<const void> under_way;  // counts it, as long as there is one, in CallCount
};

// The door: lets in who may, counts the calls under way, and counts who leaves with an error. Every
// call of every service comes by here before its request is read. Health and reflection need
// no token: they tell what anybody may know (whether the server serves, and the contract), and
// those who watch servers have none.
// Threads: any method from any thread.
class CallAccounting {
 public:
  // What is pointed to must outlive this.
  CallAccounting(Authenticator authenticator, absl::Duration request_timeout,
                 Connections* connections, Quotas* quotas, Metrics* metrics);

  // How long the first request of a call may take to arrive.
  absl::Duration request_timeout() const { return request_timeout_; }

  // Lets a call in. Errors: those of Authenticator::OwnerOf; RESOURCE_EXHAUSTED the owner has too
  // many calls under way.
  absl::StatusOr<Caller> Admit(const grpc::ServerContextBase& context) const;

  // Lets a call in that nobody has to show a token for. Errors: RESOURCE_EXHAUSTED its connection
  // has kOpenCallCountMax of them.
  absl::StatusOr<AnonymousCall> AdmitAnonymous(const grpc::ServerContextBase& context) const;

  // Counts a call that asks for what there is not.
  void Refuse(const grpc::ServerContextBase& context) const;

  // Counts `bytes` of requests or responses among the buffers of `owner`. Errors:
  // RESOURCE_EXHAUSTED.
  absl::StatusOr<Quotas::Reservation> HoldBytes(absl::string_view owner, int64_t bytes) const {
    return quotas_->Reserve(owner, {.buffer_bytes = bytes});
  }

  // How a call of `method` ("PoolService/CreatePool") is answered that ended with `status`. Every
  // call and stream ends by here, let in or not; errors are counted.
  grpc::Status EndCall(absl::string_view method, const absl::Status& status) const;

  // Calls and streams that were let in and whose answers are not on their way yet.
  int64_t CallCount() const { return counted_.use_count() - 1; }

 private:
  const Authenticator authenticator_;
  const absl::Duration request_timeout_;
  Connections* const connections_;
  Quotas* const quotas_;
  Metrics* const metrics_;
  const std::shared_ptr<const void> counted_ = std::make_shared<char>();  // shared by each Caller
};

}  // namespace procgen

#endif  // SERVER_RPC_AUTH_CALL_ACCOUNTING_H_
