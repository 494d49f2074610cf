#ifndef SERVER_RPC_DRAIN_TRAILER_H_
#define SERVER_RPC_DRAIN_TRAILER_H_

#include "absl/status/status.h"
#include "grpcpp/server_context.h"

namespace procgen {

// Tells a client whose stream ends with `status`, if it is UNAVAILABLE, that this server will not
// serve it, so that it does not try the same again. Other UNAVAILABLEs are broken connections.
inline void AddDrainTrailer(const absl::Status& status, grpc::CallbackServerContext* context) {
  if (absl::IsUnavailable(status)) {
    context->AddTrailingMetadata("procgen-drains", "1");
  }
}

}  // namespace procgen

#endif  // SERVER_RPC_DRAIN_TRAILER_H_
