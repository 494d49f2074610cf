#include "server/rpc/grpc_status.h"

#include <string>

namespace procgen {

grpc::Status ToGrpcStatus(const absl::Status& status) {
  return {static_cast<grpc::StatusCode>(status.code()), std::string(status.message())};
}

}  // namespace procgen
