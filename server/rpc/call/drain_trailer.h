#ifndef SERVER_RPC_CALL_DRAIN_TRAILER_H_
#define SERVER_RPC_CALL_DRAIN_TRAILER_H_

#include "absl/status/status.h"
#include "grpcpp/server_context.h"
#include "server/session/pool_supervisor.h"

namespace procgen {

// Tells a client whose stream ends with `status`, if it is UNAVAILABLE, that this server will not
// serve it, so that it does not try the same again. Other UNAVAILABLEs are broken connections, and
// servers that keep their pools: there it is to try until the server is back.
inline void AddDrainTrailer(const absl::Status& status, const PoolSupervisor& supervisor,
                            grpc::CallbackServerContext* context) {
  if (absl::IsUnavailable(status) && !supervisor.keeps_pools()) {
    context->AddTrailingMetadata("procgen-drains", "1");
  }
}

}  // namespace procgen

#endif  // SERVER_RPC_CALL_DRAIN_TRAILER_H_
