#include "server/rpc/grpc/grpc_status.h"

#include <cstdint>
#include <string>

#include "absl/strings/string_view.h"

namespace procgen {
namespace {

// Whether `byte` is a byte of a UTF-8 character other than its first.
bool IsUtf8Continuation(char byte) { return (static_cast<uint8_t>(byte) & 0xC0U) == 0x80U; }

}  // namespace

grpc::Status ToGrpcStatus(const absl::Status& status) {
  absl::string_view message = status.message();
  if (message.size() > kStatusMessageBytesMax) {
    size_t size = kStatusMessageBytesMax;
    while (size > 0 && IsUtf8Continuation(message[size])) {
      --size;
    }
    message = message.substr(0, size);
  }
  return {static_cast<grpc::StatusCode>(status.code()), std::string(message)};
}

}  // namespace procgen
