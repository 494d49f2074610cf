#ifndef PROCGEN_CLIENT_INTERNAL_GRPC_ERROR_H_
#define PROCGEN_CLIENT_INTERNAL_GRPC_ERROR_H_

#include "absl/status/status.h"
#include "grpcpp/support/status.h"

namespace procgen_client {

inline absl::Status ToAbslStatus(const grpc::Status& status) {
  return {static_cast<absl::StatusCode>(status.error_code()), status.error_message()};
}

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_INTERNAL_GRPC_ERROR_H_
