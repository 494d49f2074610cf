#ifndef SERVER_RPC_BRIDGE_GENERIC_STUB_H_
#define SERVER_RPC_BRIDGE_GENERIC_STUB_H_

#include <memory>

#include "grpcpp/channel.h"
#include "server/rpc/bridge/generic_call.h"

namespace procgen {

// Returns a stub that starts calls on `channel`.
std::unique_ptr<GenericStub> MakeGenericStub(const std::shared_ptr<grpc::Channel>& channel);

}  // namespace procgen

#endif  // SERVER_RPC_BRIDGE_GENERIC_STUB_H_
