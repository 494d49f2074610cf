#include "procgen_client/grpc_error.h"

namespace procgen_client {

absl::Status ToAbslStatus(const grpc::Status& status) {
  return {static_cast<absl::StatusCode>(status.error_code()), status.error_message()};
}

bool IsBrokenConnection(const grpc::Status& status, const grpc::ClientContext& context) {
  switch (status.error_code()) {
    case grpc::StatusCode::UNAVAILABLE:
      // A server that drains says so, and that it is not to be asked again.
      return !context.GetServerTrailingMetadata().contains("procgen-drains");
    case grpc::StatusCode::UNKNOWN:  // "Stream removed": gRPC's word where a socket was reset
    case grpc::StatusCode::OK:       // the server took the connection's end for the stream's
      return true;
    default:
      return false;
  }
}

}  // namespace procgen_client
