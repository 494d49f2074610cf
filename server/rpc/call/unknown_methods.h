#ifndef SERVER_RPC_CALL_UNKNOWN_METHODS_H_
#define SERVER_RPC_CALL_UNKNOWN_METHODS_H_

#include "absl/status/status.h"
#include "grpcpp/generic/async_generic_service.h"
#include "server/rpc/auth/caller.h"
#include "server/rpc/call/byte_service.h"
#include "server/rpc/call/refused_stream.h"
#include "server/rpc/grpc/grpc_status.h"

namespace procgen {

// All methods that no service has: they are refused, and count so.
class UnknownMethods final : public grpc::CallbackGenericService {
 public:
  // `callers` must outlive this.
  explicit UnknownMethods(const Callers* callers) : callers_(callers) {}

 private:
  ByteStream* CreateReactor(grpc::GenericCallbackServerContext* context) override {
    callers_->Refuse(*context);
    return new RefusedStream(
        ToGrpcStatus(absl::UnimplementedError("this server has no such method")));
  }

  const Callers* const callers_;
};

}  // namespace procgen

#endif  // SERVER_RPC_CALL_UNKNOWN_METHODS_H_
