#ifndef SERVER_RPC_CALL_UNKNOWN_METHODS_H_
#define SERVER_RPC_CALL_UNKNOWN_METHODS_H_

#include "absl/status/status.h"
#include "grpcpp/generic/async_generic_service.h"
#include "server/rpc/call/byte_service.h"
#include "server/rpc/call/refused_stream.h"
#include "server/rpc/grpc/grpc_status.h"

namespace procgen {

// Handles calls of unknown methods: they fail with UNIMPLEMENTED.
class UnknownMethods final : public grpc::CallbackGenericService {
 private:
  ByteStream* CreateReactor(grpc::GenericCallbackServerContext* /*context*/) override {
    return new RefusedStream(
        ToGrpcStatus(absl::UnimplementedError("this server has no such method")));
  }
};

}  // namespace procgen

#endif  // SERVER_RPC_CALL_UNKNOWN_METHODS_H_
