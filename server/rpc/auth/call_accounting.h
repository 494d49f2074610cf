#ifndef SERVER_RPC_AUTH_CALL_ACCOUNTING_H_
#define SERVER_RPC_AUTH_CALL_ACCOUNTING_H_

#include <cstdint>
#include <memory>
#include <string>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "grpcpp/server_context.h"
#include "grpcpp/support/server_callback.h"
#include "grpcpp/support/status.h"
#include "server/metrics/metrics.h"
#include "server/pool/quota/quotas.h"
#include "server/rpc/auth/authenticator.h"

namespace procgen {

// An admitted caller.
struct Caller {
  std::string owner;                      // of its pools; empty without authentication
  Quotas::Reservation reservation;        // one of the owner's calls in progress
  std::shared_ptr<const void> under_way;  // counted by CallCount while it exists
};

// Admits calls, counts the calls in progress, and counts errors: of every service but health and
// reflection. Those need no token: their contents are public, and monitoring has no tokens.
// Threads: any method from any thread.
class CallAccounting {
 public:
  // The pointers must outlive this object.
  CallAccounting(Authenticator authenticator, Quotas* quotas, Metrics* metrics);

  // Admits a call. Errors: those of Authenticator::OwnerOf; RESOURCE_EXHAUSTED the owner has too
  // many calls in progress.
  absl::StatusOr<Caller> Admit(const grpc::ServerContextBase& context) const;

  // Answers a unary call at once: admits it and ends it with the status of `serve`, which receives
  // the caller's owner.
  grpc::ServerUnaryReactor* Answer(
      grpc::CallbackServerContext* context, absl::string_view method,
      absl::FunctionRef<absl::Status(const std::string& owner)> serve) const;

  // Returns the gRPC status of a call of `method` ("PoolService/GetPool") that ended with
  // `status`, and counts errors. Called for every call and stream, admitted or not.
  grpc::Status EndCall(absl::string_view method, const absl::Status& status) const;

  // Admitted calls and streams whose answers are not being sent yet.
  int64_t CallCount() const { return counted_.use_count() - 1; }

 private:
  const Authenticator authenticator_;
  Quotas* const quotas_;
  Metrics* const metrics_;
  const std::shared_ptr<const void> counted_ = std::make_shared<char>();  // shared by each Caller
};

}  // namespace procgen

#endif  // SERVER_RPC_AUTH_CALL_ACCOUNTING_H_
