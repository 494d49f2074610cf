#include "procgen_client/direct_line.h"

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace procgen_client {
namespace {

constexpr size_t kLengthBytes = sizeof(uint32_t);
// Answers are small: the values are in shared memory.
constexpr size_t kBufferBytes = 4096;
// Who has waited for an answer waits for the next ones, too, as a rule: so often it is not tried
// first whether they are there.
constexpr int kWaitsExpected = 64;

}  // namespace

std::unique_ptr<DirectLine> DirectLine::Open(const procgen::v1::DirectLine& offer) {
  const std::string& name = offer.socket_name();
  sockaddr_un address = {};
  if (name.empty() || name.size() >= sizeof(address.sun_path)) {
    return nullptr;
  }
  const int descriptor = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (descriptor < 0) {
    return nullptr;
  }
  std::unique_ptr<DirectLine> line(new DirectLine(descriptor));
  // A name without a file begins with a byte 0.
  address.sun_family = AF_UNIX;
  std::copy(name.begin(), name.end(), address.sun_path + 1);
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size());
  if (connect(descriptor, reinterpret_cast<const sockaddr*>(&address), size) != 0 ||
      !line->SendAll(offer.key())) {
    return nullptr;
  }
  return line;
}

DirectLine::~DirectLine() { close(descriptor_); }

bool DirectLine::Send(const procgen::v1::StepPoolRequest& request) {
  outgoing_.assign(kLengthBytes, '\0');
  request.AppendToString(&outgoing_);
  const auto length = static_cast<uint32_t>(outgoing_.size() - kLengthBytes);
  std::memcpy(outgoing_.data(), &length, kLengthBytes);
  return SendAll(outgoing_);
}

bool DirectLine::SendAll(const std::string& bytes) {
  size_t sent = 0;
  while (sent < bytes.size()) {
    const ssize_t count = send(descriptor_, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
    if (count < 0 && errno == EINTR) {
      continue;
    }
    if (count < 0) {
      return false;
    }
    sent += static_cast<size_t>(count);
  }
  return true;
}

bool DirectLine::Receive(procgen::v1::StepPoolResponse* response) {
  if (!Fill(kLengthBytes)) {
    return false;
  }
  uint32_t length = 0;
  std::memcpy(&length, buffer_.data() + begin_, kLengthBytes);
  begin_ += kLengthBytes;
  if (!Fill(length)) {
    return false;
  }
  const bool is_valid = response->ParseFromArray(buffer_.data() + begin_, static_cast<int>(length));
  begin_ += length;
  return is_valid;
}

bool DirectLine::Fill(size_t count) {
  if (begin_ == end_) {
    begin_ = end_ = 0;
  }
  if (begin_ + count > buffer_.size()) {
    std::copy(buffer_.begin() + static_cast<ptrdiff_t>(begin_),
              buffer_.begin() + static_cast<ptrdiff_t>(end_), buffer_.begin());
    end_ -= begin_;
    begin_ = 0;
    buffer_.resize(std::max({buffer_.size(), count, kBufferBytes}));
  }
  while (end_ - begin_ < count) {
    if (waits_expected_ > 0) {
      --waits_expected_;
      // Who waits in recv is woken for nothing whenever the server reads what was sent.
      pollfd input = {.fd = descriptor_, .events = POLLIN, .revents = 0};
      poll(&input, 1, -1);
    }
    const ssize_t received =
        recv(descriptor_, buffer_.data() + end_, buffer_.size() - end_, MSG_DONTWAIT);
    if (received < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) {
      waits_expected_ = kWaitsExpected;
      continue;
    }
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

void DirectLine::HangUp() { shutdown(descriptor_, SHUT_RDWR); }

}  // namespace procgen_client
