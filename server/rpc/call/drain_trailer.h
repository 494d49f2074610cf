#ifndef SERVER_RPC_CALL_DRAIN_TRAILER_H_
#define SERVER_RPC_CALL_DRAIN_TRAILER_H_

#include "absl/status/status.h"
#include "grpcpp/server_context.h"
#include "server/session/pool_supervisor.h"

namespace procgen {

// Adds the trailing metadata of a drain if `status` is UNAVAILABLE and the server does not keep its
// pools. Clients then do not retry on this server. Without it, UNAVAILABLE is a broken connection
// or a server that restarts with its pools, so clients retry.
inline void AddDrainTrailer(const absl::Status& status, const PoolSupervisor& supervisor,
                            grpc::CallbackServerContext* context) {
  if (absl::IsUnavailable(status) && !supervisor.keeps_pools()) {
    context->AddTrailingMetadata("procgen-drains", "1");
  }
}

}  // namespace procgen

#endif  // SERVER_RPC_CALL_DRAIN_TRAILER_H_
