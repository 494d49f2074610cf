#include "server/rpc/auth/call_accounting.h"

#include <utility>

#include "server/logging/event_log.h"
#include "server/rpc/grpc/grpc_status.h"

namespace procgen {

CallAccounting::CallAccounting(Authenticator authenticator, Quotas* quotas, Metrics* metrics)
    : authenticator_(std::move(authenticator)), quotas_(quotas), metrics_(metrics) {}

absl::StatusOr<Caller> CallAccounting::Admit(const grpc::ServerContextBase& context) const {
  absl::StatusOr<std::string> owner = authenticator_.OwnerOf(context);
  if (!owner.ok()) {
    // Logged as debug only, because any client can cause any number of these lines.
    LogEvent(LogLevel::kDebug, "caller_refused",
             {{"peer", context.peer()}, {"message", std::string(owner.status().message())}});
    return owner.status();
  }
  absl::StatusOr<Quotas::Reservation> reservation = quotas_->Reserve(*owner, {.call_count = 1});
  if (!reservation.ok()) {
    return reservation.status();
  }
  return Caller{*std::move(owner), *std::move(reservation), counted_};
}

grpc::ServerUnaryReactor* CallAccounting::Answer(
    grpc::CallbackServerContext* context, absl::string_view method,
    absl::FunctionRef<absl::Status(const std::string& owner)> serve) const {
  const absl::StatusOr<Caller> caller = Admit(*context);
  grpc::ServerUnaryReactor* const reactor = context->DefaultReactor();
  reactor->Finish(EndCall(method, caller.ok() ? serve(caller->owner) : caller.status()));
  return reactor;
}

grpc::Status CallAccounting::EndCall(absl::string_view method, const absl::Status& status) const {
  if (!status.ok()) {
    metrics_->AddError(method, status.code());
  }
  return ToGrpcStatus(status);
}

}  // namespace procgen
