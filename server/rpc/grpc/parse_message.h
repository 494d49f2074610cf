#ifndef SERVER_RPC_GRPC_PARSE_MESSAGE_H_
#define SERVER_RPC_GRPC_PARSE_MESSAGE_H_

#include <cstddef>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "grpcpp/impl/codegen/proto_utils.h"
#include "grpcpp/support/byte_buffer.h"

namespace procgen {

template <typename Message>
absl::Status ParsedStatus(bool is_valid, size_t byte_count) {
  return is_valid ? absl::OkStatus()
                  : absl::InvalidArgumentError(absl::StrCat("the request's ", byte_count,
                                                            " bytes are not a valid ",
                                                            Message::descriptor()->full_name()));
}

// Parses serialised bytes into `message`. Errors: INVALID_ARGUMENT.
template <typename Message>
absl::Status ParseMessage(absl::string_view bytes, Message* message) {
  return ParsedStatus<Message>(
      message->ParseFromArray(bytes.data(), static_cast<int>(bytes.size())), bytes.size());
}
template <typename Message>
absl::Status ParseMessage(const grpc::ByteBuffer& bytes, Message* message) {
  // Small requests have a single slice and are parsed in place: gRPC's reader takes 2 us longer.
  if (grpc::Slice piece; bytes.TrySingleSlice(&piece).ok()) {
    return ParseMessage(
        absl::string_view(reinterpret_cast<const char*>(piece.begin()), piece.size()), message);
  }
  grpc::ByteBuffer consumed(bytes);  // shares the bytes
  const bool is_valid = grpc::SerializationTraits<Message>::Deserialize(&consumed, message).ok();
  return ParsedStatus<Message>(is_valid, bytes.Length());
}

}  // namespace procgen

#endif  // SERVER_RPC_GRPC_PARSE_MESSAGE_H_
