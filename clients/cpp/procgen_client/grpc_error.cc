#include "procgen_client/grpc_error.h"

namespace procgen_client {

absl::Status ToAbslStatus(const grpc::Status& status) {
  return {static_cast<absl::StatusCode>(status.error_code()), status.error_message()};
}

}  // namespace procgen_client
