#include "server/shared_memory/pipe_connection.h"

#include <fcntl.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"

namespace procgen {
namespace {

constexpr size_t kLengthBytes = sizeof(uint32_t);
// Enough for requests of some hundred environments; grows for larger ones.
constexpr size_t kBufferBytes = 4096;

absl::Status Ended() { return absl::CancelledError("the pipe transport has ended"); }

}  // namespace

std::unique_ptr<PipeConnection> PipeConnection::Make(size_t message_bytes_max) {
  std::unique_ptr<PipeConnection> pipes(new PipeConnection(message_bytes_max));
  return pipes->MakePipes() && pipes->WatchPipes() ? std::move(pipes) : nullptr;
}

PipeConnection::PipeConnection(size_t message_bytes_max)
    : message_bytes_max_(message_bytes_max), buffer_(kBufferBytes) {}

PipeConnection::~PipeConnection() = default;

bool PipeConnection::MakePipes() {
  std::array<int, 2> requests = {-1, -1};
  std::array<int, 2> responses = {-1, -1};
  const bool made =
      pipe2(requests.data(), O_CLOEXEC) == 0 && pipe2(responses.data(), O_CLOEXEC) == 0;
  requests_ = FileDescriptor(requests[0]);
  learners_requests_ = FileDescriptor(requests[1]);
  learners_responses_ = FileDescriptor(responses[0]);
  responses_ = FileDescriptor(responses[1]);
  // The learner decides whether its ends block.
  return made && fcntl(requests_.number(), F_SETFL, O_NONBLOCK) == 0 &&
         fcntl(responses_.number(), F_SETFL, O_NONBLOCK) == 0;
}

bool PipeConnection::WatchPipes() {
  responses_read_ = FileDescriptor(fcntl(learners_responses_.number(), F_DUPFD_CLOEXEC, 0));
  watch_ = FileDescriptor(epoll_create1(EPOLL_CLOEXEC));
  epoll_event end_only = {};
  end_only.events = EPOLLONESHOT;
  return responses_read_.is_open() && watch_.is_open() &&
         epoll_ctl(watch_.number(), EPOLL_CTL_ADD, requests_.number(), &end_only) == 0 &&
         epoll_ctl(watch_.number(), EPOLL_CTL_ADD, responses_read_.number(), &end_only) == 0;
}

bool PipeConnection::HandOver(int socket) {
  const FileDescriptor requests = std::move(learners_requests_);
  const FileDescriptor responses = std::move(learners_responses_);
  const std::array<int, 2> ends = {requests.number(), responses.number()};
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(ends))> control = {};
  char nothing = 0;
  iovec content = {.iov_base = &nothing, .iov_len = 1};
  msghdr message = {};
  message.msg_iov = &content;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  cmsghdr* const head = CMSG_FIRSTHDR(&message);
  head->cmsg_level = SOL_SOCKET;
  head->cmsg_type = SCM_RIGHTS;
  head->cmsg_len = CMSG_LEN(sizeof(ends));
  std::memcpy(CMSG_DATA(head), ends.data(), sizeof(ends));
  return sendmsg(socket, &message, MSG_NOSIGNAL) == 1;
}

absl::StatusOr<std::optional<absl::string_view>> PipeConnection::Receive() {
  uint32_t length = 0;
  Filled filled = Fill(kLengthBytes);
  if (filled == Filled::kYes) {
    std::memcpy(&length, buffer_.data() + begin_, kLengthBytes);
    if (length > message_bytes_max_) {
      return absl::ResourceExhaustedError(absl::StrCat(
          "a request of ", length, " bytes, limit request_bytes_max is ", message_bytes_max_));
    }
    filled = Fill(kLengthBytes + length);
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

PipeConnection::Filled PipeConnection::Fill(size_t count) {
  if (begin_ == end_) {
    begin_ = end_ = 0;
  }
  if (begin_ + count > buffer_.size()) {
    std::copy(buffer_.begin() + static_cast<ptrdiff_t>(begin_),
              buffer_.begin() + static_cast<ptrdiff_t>(end_), buffer_.begin());
    end_ -= begin_;
    begin_ = 0;
    buffer_.resize(std::max(buffer_.size(), count));
  }
  while (end_ - begin_ < count) {
    const ssize_t received = read(requests_.number(), buffer_.data() + end_, buffer_.size() - end_);
    if (received < 0 && errno == EINTR) {
      continue;
    }
    if (received <= 0) {
      const bool is_to_come = received < 0 && errno == EAGAIN && !hung_up_;
      return is_to_come ? Filled::kNotYet : Filled::kEnded;
    }
    end_ += static_cast<size_t>(received);
  }
  return Filled::kYes;
}

void PipeConnection::Watch() {
  epoll_event input = {};
  input.events = EPOLLIN | EPOLLONESHOT;
  epoll_ctl(watch_.number(), EPOLL_CTL_MOD, requests_.number(), &input);
}

bool PipeConnection::AwaitInput() {
  epoll_event input = {};
  while (!hung_up_ && epoll_wait(watch_.number(), &input, 1, -1) < 0 && errno == EINTR) {
  }
  return !hung_up_;
}

bool PipeConnection::Send(const std::vector<absl::string_view>& pieces) {
  outgoing_.assign(kLengthBytes, '\0');
  for (const absl::string_view piece : pieces) {
    absl::StrAppend(&outgoing_, piece);
  }
  const auto length = static_cast<uint32_t>(outgoing_.size() - kLengthBytes);
  std::memcpy(outgoing_.data(), &length, kLengthBytes);
  // A full pipe means that the peer has not read for long: a stream has few responses in flight,
  // and those with shared memory are small.
  ssize_t sent = 0;
  do {
    sent = write(responses_.number(), outgoing_.data(), outgoing_.size());
  } while (sent < 0 && errno == EINTR);
  return sent == static_cast<ssize_t>(outgoing_.size());
}

void PipeConnection::HangUp() {
  hung_up_ = true;
  // Atomically replaces the write end for all threads; its number cannot be reused by another file
  // meanwhile.
  dup3(responses_read_.number(), responses_.number(), O_CLOEXEC);
}

}  // namespace procgen
