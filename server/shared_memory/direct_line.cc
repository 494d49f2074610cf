#include "server/shared_memory/direct_line.h"

#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"

namespace procgen {
namespace {

constexpr size_t kLengthBytes = sizeof(uint32_t);
// Enough for the requests of some hundred environments; larger ones make room.
constexpr size_t kBufferBytes = 4096;

absl::Status Ended() { return absl::CancelledError("the direct line has ended"); }

}  // namespace

DirectLine::DirectLine(int descriptor, size_t message_bytes_max)
    : descriptor_(descriptor), message_bytes_max_(message_bytes_max), buffer_(kBufferBytes) {}

DirectLine::~DirectLine() { close(descriptor_); }

absl::StatusOr<absl::string_view> DirectLine::Receive() {
  if (!Fill(kLengthBytes)) {
    return Ended();
  }
  uint32_t length = 0;
  std::memcpy(&length, buffer_.data() + begin_, kLengthBytes);
  begin_ += kLengthBytes;
  if (length > message_bytes_max_) {
    return absl::ResourceExhaustedError(absl::StrCat(
        "a request of ", length, " bytes, limit request_bytes_max is ", message_bytes_max_));
  }
  return ReceiveBytes(length);
}

absl::StatusOr<absl::string_view> DirectLine::ReceiveBytes(size_t count) {
  if (!Fill(count)) {
    return Ended();
  }
  const absl::string_view bytes(buffer_.data() + begin_, count);
  begin_ += count;
  return bytes;
}

bool DirectLine::Fill(size_t count) {
  if (begin_ == end_) {
    begin_ = end_ = 0;
  }
  if (begin_ + count > buffer_.size()) {
    std::copy(buffer_.begin() + begin_, buffer_.begin() + end_, buffer_.begin());
    end_ -= begin_;
    begin_ = 0;
    buffer_.resize(std::max(buffer_.size(), count));
  }
  while (end_ - begin_ < count) {
    const ssize_t received = recv(descriptor_, buffer_.data() + end_, buffer_.size() - end_, 0);
    if (received < 0 && errno == EINTR) {
      continue;
    }
    if (received <= 0) {
      return false;
    }
    end_ += static_cast<size_t>(received);
  }
  return true;
}

bool DirectLine::Send(const std::vector<absl::string_view>& pieces) {
  outgoing_.assign(kLengthBytes, '\0');
  for (const absl::string_view piece : pieces) {
    absl::StrAppend(&outgoing_, piece);
  }
  const auto length = static_cast<uint32_t>(outgoing_.size() - kLengthBytes);
  std::memcpy(outgoing_.data(), &length, kLengthBytes);
  // Where there is no room for all of it, nobody has read for long: a stream has few responses, and
  // those that share memory are small.
  ssize_t sent = 0;
  do {
    sent = send(descriptor_, outgoing_.data(), outgoing_.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  } while (sent < 0 && errno == EINTR);
  return sent == static_cast<ssize_t>(outgoing_.size());
}

void DirectLine::HangUp() { shutdown(descriptor_, SHUT_RDWR); }

}  // namespace procgen
