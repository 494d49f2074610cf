#ifndef SERVER_RPC_UNKNOWN_METHODS_H_
#define SERVER_RPC_UNKNOWN_METHODS_H_

#include "absl/status/status.h"
#include "grpcpp/generic/async_generic_service.h"
#include "server/rpc/byte_service.h"
#include "server/rpc/caller.h"
#include "server/rpc/grpc_status.h"
#include "server/rpc/refused_stream.h"

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

#endif  // SERVER_RPC_UNKNOWN_METHODS_H_
