#include "procgen_client/internal/pipe_transport.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <utility>

#include "absl/cleanup/cleanup.h"
#include "absl/strings/str_cat.h"

namespace procgen_client {
namespace {

constexpr size_t kLengthBytes = sizeof(uint32_t);
// Responses are small, because values are in shared memory.
constexpr size_t kBufferBytes = 4096;

const auto kPollMilliseconds = static_cast<int>(kCancellationInterval / absl::Milliseconds(1));

// Timeout of the socket exchange.
constexpr timeval kAnswerTimeout = {.tv_sec = 2, .tv_usec = 0};

bool IsPipe(int file) {
  struct stat facts = {};
  return fstat(file, &facts) == 0 && S_ISFIFO(facts.st_mode);
}

// Returns a socket connected to an abstract name; negative on failure.
int ConnectedTo(const std::string& name) {
  sockaddr_un address = {};
  if (name.empty() || name.size() >= sizeof(address.sun_path)) {
    return -1;
  }
  const int connection = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (connection < 0) {
    return -1;
  }
  // Abstract names start with a byte 0.
  address.sun_family = AF_UNIX;
  setsockopt(connection, SOL_SOCKET, SO_RCVTIMEO, &kAnswerTimeout, sizeof(kAnswerTimeout));
  setsockopt(connection, SOL_SOCKET, SO_SNDTIMEO, &kAnswerTimeout, sizeof(kAnswerTimeout));
  std::copy(name.begin(), name.end(), address.sun_path + 1);
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size());
  if (connect(connection, reinterpret_cast<const sockaddr*>(&address), size) != 0) {
    close(connection);
    return -1;
  }
  return connection;
}

}  // namespace

std::unique_ptr<PipeTransport> PipeTransport::Open(const procgen::v1::PipeTransport& offer,
                                                   int64_t response_bytes_max,
                                                   std::shared_ptr<Cancellation> cancellation) {
  const int connection = ConnectedTo(offer.socket_name());
  if (connection < 0) {
    return nullptr;
  }
  const absl::Cleanup disconnect = [connection] { close(connection); };
  const std::string& key = offer.key();
  const ssize_t shown = send(connection, key.data(), key.size(), MSG_NOSIGNAL);
  std::unique_ptr<PipeTransport> pipes(
      new PipeTransport(response_bytes_max, std::move(cancellation)));
  return shown == static_cast<ssize_t>(key.size()) && pipes->TakeEnds(connection) ? std::move(pipes)
                                                                                  : nullptr;
}

bool PipeTransport::TakeEnds(int socket) {
  std::array<int, 2> ends = {-1, -1};
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(ends))> control = {};
  char nothing = 0;
  iovec content = {.iov_base = &nothing, .iov_len = 1};
  msghdr message = {};
  message.msg_iov = &content;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  if (recvmsg(socket, &message, MSG_CMSG_CLOEXEC) != 1) {
    return false;
  }
  const cmsghdr* const head = CMSG_FIRSTHDR(&message);
  if (head == nullptr || head->cmsg_type != SCM_RIGHTS ||
      head->cmsg_len != CMSG_LEN(sizeof(ends))) {
    return false;
  }
  std::memcpy(ends.data(), CMSG_DATA(head), sizeof(ends));
  requests_ = ends[0];
  responses_ = ends[1];
  if (!IsPipe(requests_) || !IsPipe(responses_)) {
    return false;
  }
  const std::string again = absl::StrCat("/proc/self/fd/", requests_);
  requests_read_ = open(again.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  return requests_read_ >= 0 && fcntl(requests_, F_SETFL, O_NONBLOCK) == 0 &&
         (!cancellation_->has_check() || fcntl(responses_, F_SETFL, O_NONBLOCK) == 0);
}

PipeTransport::~PipeTransport() {
  for (const int end : {requests_, requests_read_, responses_}) {
    if (end >= 0) {
      close(end);
    }
  }
}

bool PipeTransport::Send(const procgen::v1::StepPoolRequest& request) {
  outgoing_.assign(kLengthBytes, '\0');
  request.AppendToString(&outgoing_);
  const auto length = static_cast<uint32_t>(outgoing_.size() - kLengthBytes);
  std::memcpy(outgoing_.data(), &length, kLengthBytes);
  size_t sent = 0;
  while (sent < outgoing_.size()) {
    const ssize_t count = write(requests_, outgoing_.data() + sent, outgoing_.size() - sent);
    if (count >= 0) {
      sent += static_cast<size_t>(count);
    } else if (errno != EINTR && (errno != EAGAIN || !AwaitRoom())) {
      return false;
    }
  }
  return true;
}

bool PipeTransport::AwaitRoom() const {
  std::array<pollfd, 2> ends = {{{.fd = requests_, .events = POLLOUT, .revents = 0},
                                 {.fd = responses_, .events = 0, .revents = 0}}};
  while (poll(ends.data(), ends.size(), kPollMilliseconds) <= 0) {
    if (cancellation_->Check()) {
      return false;
    }
  }
  return (ends[1].revents & POLLHUP) == 0;
}

bool PipeTransport::AwaitResponse() const {
  pollfd end = {.fd = responses_, .events = POLLIN, .revents = 0};
  while (poll(&end, 1, kPollMilliseconds) <= 0) {
    if (cancellation_->Check()) {
      return false;
    }
  }
  return true;
}

bool PipeTransport::Receive(procgen::v1::StepPoolResponse* response) {
  if (!Fill(kLengthBytes)) {
    return false;
  }
  uint32_t length = 0;
  std::memcpy(&length, buffer_.data() + begin_, kLengthBytes);
  begin_ += kLengthBytes;
  if (length > response_bytes_max_) {
    is_damaged_ = true;
    return false;
  }
  if (!Fill(length)) {
    return false;
  }
  is_damaged_ = !response->ParseFromArray(buffer_.data() + begin_, static_cast<int>(length));
  begin_ += length;
  return !is_damaged_;
}

bool PipeTransport::Fill(size_t count) {
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
    // Cancelled before this connection was known to Interrupt.
    if (cancellation_->is_cancelled()) {
      return false;
    }
    const ssize_t received = read(responses_, buffer_.data() + end_, buffer_.size() - end_);
    if (received < 0 && (errno == EINTR || (errno == EAGAIN && AwaitResponse()))) {
      continue;
    }
    if (received <= 0 || cancellation_->is_cancelled()) {
      return false;
    }
    end_ += static_cast<size_t>(received);
  }
  return true;
}

void PipeTransport::HangUp() const {
  // Closes the write end atomically for all threads. Replacing it by a read-only descriptor keeps
  // its number from being reused by another file.
  dup3(requests_read_, requests_, O_CLOEXEC);
}

void PipeTransport::Interrupt() const {
  // A byte wakes the reader. The write end is closed again, so that the end of the server's is
  // seen.
  const std::string response_pipe = absl::StrCat("/proc/self/fd/", responses_);
  const int write_end = open(response_pipe.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC);
  const char wake = 0;
  if (write_end >= 0) {
    // On failure the pipe is full, so the reader does not wait.
    [[maybe_unused]] const ssize_t written = write(write_end, &wake, sizeof(wake));
    close(write_end);
  }
}

}  // namespace procgen_client
