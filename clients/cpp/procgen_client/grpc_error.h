#ifndef PROCGEN_CLIENT_GRPC_ERROR_H_
#define PROCGEN_CLIENT_GRPC_ERROR_H_

#include "absl/status/status.h"
#include "grpcpp/client_context.h"
#include "grpcpp/support/status.h"

namespace procgen_client {

// The same code and message.
absl::Status ToAbslStatus(const grpc::Status& status);

// Whether a stream that its client did not end has ended because its connection broke, so that
// another try may help, and not by an answer of the server, which would be the same again. `status`
// is how it ended.
bool IsBrokenConnection(const grpc::Status& status, const grpc::ClientContext& context);

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_GRPC_ERROR_H_
