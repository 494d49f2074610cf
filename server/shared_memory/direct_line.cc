#include "server/shared_memory/direct_line.h"

#include <sys/epoll.h>
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

std::unique_ptr<DirectLine> DirectLine::Take(int descriptor, size_t message_bytes_max) {
  const int watch = epoll_create1(EPOLL_CLOEXEC);
  epoll_event nothing = {};
  if (watch < 0 || epoll_ctl(watch, EPOLL_CTL_ADD, descriptor, &nothing) != 0) {
    if (watch >= 0) {
      close(watch);
    }
    close(descriptor);
    return nullptr;
  }
  return std::unique_ptr<DirectLine>(new DirectLine(descriptor, watch, message_bytes_max));
}

DirectLine::DirectLine(int descriptor, int watch, size_t message_bytes_max)
    : descriptor_(descriptor),
      watch_(watch),
      message_bytes_max_(message_bytes_max),
      buffer_(kBufferBytes) {}

DirectLine::~DirectLine() {
  close(watch_);
  close(descriptor_);
}

absl::StatusOr<absl::string_view> DirectLine::ReceiveBytes(size_t count) {
  if (Fill(count, true) != Filled::kYes) {
    return Ended();
  }
  const absl::string_view bytes(buffer_.data() + begin_, count);
  begin_ += count;
  return bytes;
}

absl::StatusOr<std::optional<absl::string_view>> DirectLine::Receive() {
  uint32_t length = 0;
  Filled filled = Fill(kLengthBytes, false);
  if (filled == Filled::kYes) {
    std::memcpy(&length, buffer_.data() + begin_, kLengthBytes);
    if (length > message_bytes_max_) {
      return absl::ResourceExhaustedError(absl::StrCat(
          "a request of ", length, " bytes, limit request_bytes_max is ", message_bytes_max_));
    }
    filled = Fill(kLengthBytes + length, false);
  }
  if (filled == Filled::kEnded) {
    return Ended();
  }
  if (filled == Filled::kNotYet) {
    return std::nullopt;
  }
  const absl::string_view message(buffer_.data() + begin_ + kLengthBytes, length);
  begin_ += kLengthBytes + length;
  return message;
}

DirectLine::Filled DirectLine::Fill(size_t count, bool waits) {
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
    const ssize_t received =
        recv(descriptor_, buffer_.data() + end_, buffer_.size() - end_, waits ? 0 : MSG_DONTWAIT);
    if (received < 0 && errno == EINTR) {
      continue;
    }
    if (received <= 0) {
      const bool is_to_come = received < 0 && !waits && (errno == EAGAIN || errno == EWOULDBLOCK);
      return is_to_come ? Filled::kNotYet : Filled::kEnded;
    }
    end_ += static_cast<size_t>(received);
  }
  return Filled::kYes;
}

void DirectLine::Watch() {
  epoll_event input = {};
  input.events = EPOLLIN | EPOLLRDHUP | EPOLLONESHOT;
  epoll_ctl(watch_, EPOLL_CTL_MOD, descriptor_, &input);
}

bool DirectLine::AwaitInput() {
  epoll_event input = {};
  while (!hung_up_ && epoll_wait(watch_, &input, 1, -1) < 0 && errno == EINTR) {
  }
  return !hung_up_;
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

void DirectLine::HangUp() {
  hung_up_ = true;
  shutdown(descriptor_, SHUT_RDWR);
  Watch();  // has who waits find out
}

}  // namespace procgen
