#include "procgen_client/internal/grpc_error.h"

#include <cstdint>
#include <string>

#include "absl/strings/str_cat.h"

namespace procgen_client {

namespace {

constexpr bool IsControl(uint8_t byte) { return byte < 0x20 || byte == 0x7f; }

std::string WithoutControls(const std::string& text) {
  constexpr uint8_t kLead = 0xc2;  // of the control characters U+0080 to U+009F in UTF-8
  std::string shown;
  for (size_t i = 0; i < text.size(); ++i) {
    auto byte = static_cast<uint8_t>(text[i]);
    const uint8_t next = i + 1 < text.size() ? static_cast<uint8_t>(text[i + 1]) : 0;
    const bool is_pair = byte == kLead && next >= 0x80 && next < 0xa0;
    if (is_pair) {
      byte = next;
      ++i;
    }
    if (is_pair || IsControl(byte)) {
      absl::StrAppend(&shown, "\\x", absl::Hex(byte, absl::kZeroPad2));
    } else {
      shown += static_cast<char>(byte);
    }
  }
  return shown;
}

}  // namespace

absl::Status ToAbslStatus(const grpc::Status& status) {
  return {static_cast<absl::StatusCode>(status.error_code()),
          WithoutControls(status.error_message())};
}

}  // namespace procgen_client
