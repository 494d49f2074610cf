#include "server/shared_memory/pipe_listener.h"

#include <sys/random.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <iterator>
#include <system_error>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "server/concurrency/start_thread.h"

namespace procgen {
namespace {

// Time limit for a peer to send its key, and maximum number of such peers.
constexpr int kKeySeconds = 10;
constexpr int kUnknownMax = 64;
constexpr absl::Duration kNoDescriptorsPause = absl::Milliseconds(100);

std::string RandomBytes(size_t count) {
  std::string bytes(count, '\0');
  // Up to 256 bytes are returned at once and without error on current Linux.
  while (getrandom(bytes.data(), count, 0) != static_cast<ssize_t>(count)) {
  }
  return bytes;
}

bool IsOfThisUser(int connection) {
  ucred peer = {};
  socklen_t size = sizeof(peer);
  return getsockopt(connection, SOL_SOCKET, SO_PEERCRED, &peer, &size) == 0 &&
         peer.uid == geteuid();
}

void SetReceiveTimeout(int connection, int seconds) {
  const timeval timeout = {.tv_sec = seconds, .tv_usec = 0};
  setsockopt(connection, SOL_SOCKET, SO_RCVTIMEO, &timeout, sizeof(timeout));
}

// Binds to an abstract name, which begins with a byte 0.
bool BindTo(int socket, absl::string_view name) {
  sockaddr_un address = {};
  address.sun_family = AF_UNIX;
  std::copy(name.begin(), name.end(), address.sun_path + 1);
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size());
  return bind(socket, reinterpret_cast<const sockaddr*>(&address), size) == 0;
}

}  // namespace

absl::StatusOr<std::unique_ptr<PipeListener>> PipeListener::Open(size_t message_bytes_max) {
  const std::string name =
      absl::StrCat("procgen-server-", absl::BytesToHexString(RandomBytes(kKeyBytes)));
  const int listening = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (listening < 0 || !BindTo(listening, name) || listen(listening, SOMAXCONN) != 0) {
    const absl::Status status = absl::ResourceExhaustedError(
        absl::StrCat("cannot listen on a unix socket for learners that share memory: ",
                     std::generic_category().message(errno)));
    if (listening >= 0) {
      close(listening);
    }
    return status;
  }
  return std::unique_ptr<PipeListener>(new PipeListener(listening, name, message_bytes_max));
}

PipeListener::PipeListener(int socket, std::string socket_name, size_t message_bytes_max)
    : socket_(socket),
      socket_name_(std::move(socket_name)),
      message_bytes_max_(message_bytes_max),
      accepting_([this] { AcceptUntilStopped(); }) {}

PipeListener::~PipeListener() {
  {
    absl::MutexLock lock(&mutex_);
    stopping_ = true;
  }
  shutdown(socket_, SHUT_RDWR);
  accepting_.join();
  std::list<Visit> visits;
  {
    absl::MutexLock lock(&mutex_);
    visits.swap(visits_);
    for (const Visit& visit : visits) {
      if (visit.connection.is_open()) {
        shutdown(visit.connection.number(), SHUT_RDWR);
      }
      if (visit.pipes != nullptr) {
        visit.pipes->HangUp();
      }
    }
  }
  for (Visit& visit : visits) {
    visit.thread.join();
  }
  close(socket_);
}

std::string PipeListener::Expect(std::weak_ptr<PipeConnectionUser> user) {
  std::string key = RandomBytes(kKeyBytes);
  absl::MutexLock lock(&mutex_);
  expected_[key] = std::move(user);
  return key;
}

void PipeListener::Forget(const std::string& key) {
  absl::MutexLock lock(&mutex_);
  expected_.erase(key);
}

std::shared_ptr<PipeConnectionUser> PipeListener::Claim(absl::string_view key) {
  absl::MutexLock lock(&mutex_);
  const auto place = expected_.find(std::string(key));
  if (place == expected_.end()) {
    return nullptr;
  }
  const std::weak_ptr<PipeConnectionUser> user = std::move(place->second);
  expected_.erase(place);
  return user.lock();
}

void PipeListener::AcceptUntilStopped() {
  while (true) {
    FileDescriptor connection(accept4(socket_, nullptr, nullptr, SOCK_CLOEXEC));
    const int error = connection.is_open() ? 0 : errno;
    Reap();
    {
      absl::MutexLock lock(&mutex_);
      if (stopping_) {
        return;
      }
    }
    if (connection.is_open()) {
      Begin(std::move(connection));
    } else if (error == EMFILE || error == ENFILE || error == ENOBUFS || error == ENOMEM) {
      absl::SleepFor(kNoDescriptorsPause);
    }
  }
}

void PipeListener::Begin(FileDescriptor connection) {
  absl::MutexLock lock(&mutex_);
  if (stopping_ || unknown_count_ >= kUnknownMax || !IsOfThisUser(connection.number())) {
    return;
  }
  Visit& visit = visits_.emplace_back();
  visit.connection = std::move(connection);
  absl::StatusOr<std::thread> thread = StartThread([this, &visit] {
    Receive(&visit);
    absl::MutexLock over(&mutex_);
    visit.is_over = true;
    visit.pipes = nullptr;
  });
  if (!thread.ok()) {
    visits_.pop_back();  // the learner's connection closes, and it uses gRPC
    return;
  }
  ++unknown_count_;
  visit.thread = *std::move(thread);
}

std::shared_ptr<PipeConnectionUser> PipeListener::Identify(int connection) {
  SetReceiveTimeout(connection, kKeySeconds);
  std::array<char, kKeyBytes> key = {};
  const ssize_t received = recv(connection, key.data(), key.size(), MSG_WAITALL);
  return received == static_cast<ssize_t>(key.size())
             ? Claim(absl::string_view(key.data(), key.size()))
             : nullptr;
}

std::shared_ptr<PipeConnection> PipeListener::OpenPipes(Visit* visit) {
  std::shared_ptr<PipeConnection> pipes = PipeConnection::Make(message_bytes_max_);
  if (pipes == nullptr || !pipes->HandOver(visit->connection.number())) {
    return nullptr;
  }
  absl::MutexLock lock(&mutex_);
  if (stopping_) {
    return nullptr;
  }
  visit->pipes = pipes;
  return pipes;
}

void PipeListener::Receive(Visit* visit) {
  const std::shared_ptr<PipeConnectionUser> user = Identify(visit->connection.number());
  const std::shared_ptr<PipeConnection> pipes = user == nullptr ? nullptr : OpenPipes(visit);
  {
    absl::MutexLock lock(&mutex_);
    --unknown_count_;
    visit->connection = FileDescriptor();
  }
  if (pipes == nullptr) {
    return;
  }
  user->OnPipesOpened(pipes);
  bool is_open = true;
  while (is_open) {
    is_open = pipes->AwaitInput();
    user->OnPipesInput();
  }
}

void PipeListener::Reap() {
  std::list<Visit> over;
  {
    absl::MutexLock lock(&mutex_);
    for (auto visit = visits_.begin(); visit != visits_.end();) {
      const auto next = std::next(visit);
      if (visit->is_over) {
        over.splice(over.end(), visits_, visit);
      }
      visit = next;
    }
  }
  for (Visit& visit : over) {
    visit.thread.join();
  }
}

}  // namespace procgen
