#ifndef PROCGEN_CLIENT_INTERNAL_METHOD_CALL_H_
#define PROCGEN_CLIENT_INTERNAL_METHOD_CALL_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "grpcpp/channel.h"
#include "grpcpp/support/byte_buffer.h"
#include "procgen_client/internal/call_options.h"

namespace procgen_client {

// Serialised messages as those of gRPC, and back.
grpc::ByteBuffer ByteBufferOf(absl::string_view message);
std::string BytesOf(const grpc::ByteBuffer& buffer);

// Calls a unary method by its path, e.g. "/procgen.v1.PoolService/GetPool", with a serialised
// request. Returns the serialised response, which is not validated. Errors: those of the server.
absl::StatusOr<std::string> CallMethod(const std::shared_ptr<grpc::Channel>& channel,
                                       const CallOptions& options, const std::string& path,
                                       absl::string_view request);

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_INTERNAL_METHOD_CALL_H_
