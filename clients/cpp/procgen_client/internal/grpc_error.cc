#include "procgen_client/internal/grpc_error.h"

namespace procgen_client {

absl::Status ToAbslStatus(const grpc::Status& status) {
  return {static_cast<absl::StatusCode>(status.error_code()), status.error_message()};
}

bool IsBrokenConnection(const grpc::Status& status, const grpc::ClientContext& context) {
  switch (status.error_code()) {
    case grpc::StatusCode::UNAVAILABLE:
      // A server that drains must not be retried.
      return !context.GetServerTrailingMetadata().contains("procgen-drains");
    case grpc::StatusCode::UNKNOWN:  // "Stream removed": gRPC's status after a socket reset
    case grpc::StatusCode::OK:       // the server took the end of the connection for a half-close
      return true;
    default:
      return false;
  }
}

}  // namespace procgen_client
