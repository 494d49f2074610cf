#ifndef SERVER_RPC_CALL_UNKNOWN_METHODS_H_
#define SERVER_RPC_CALL_UNKNOWN_METHODS_H_

#include "absl/status/status.h"
#include "grpcpp/generic/async_generic_service.h"
#include "server/rpc/auth/call_accounting.h"
#include "server/rpc/call/byte_service.h"
#include "server/rpc/call/refused_stream.h"
#include "server/rpc/grpc/grpc_status.h"

namespace procgen {

// Handles calls of unknown methods: they fail with UNIMPLEMENTED and count as refused.
class UnknownMethods final : public grpc::CallbackGenericService {
 public:
  // `accounting` must outlive this.
  explicit UnknownMethods(const CallAccounting* accounting) : accounting_(accounting) {}

 private:
  ByteStream* CreateReactor(grpc::GenericCallbackServerContext* context) override {
    accounting_->Refuse(*context);
    return new RefusedStream(
        ToGrpcStatus(absl::UnimplementedError("this server has no such method")));
  }

  const CallAccounting* const accounting_;
};

}  // namespace procgen

#endif  // SERVER_RPC_CALL_UNKNOWN_METHODS_H_
