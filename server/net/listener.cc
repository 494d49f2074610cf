#include "server/net/listener.h"

#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <utility>

#include "absl/cleanup/cleanup.h"
#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "server/concurrency/steady_time.h"
#include "server/logging/event_log.h"

namespace procgen {
namespace {

constexpr int kWaitingMax = 1024;  // backlog: connections that are not accepted yet
// Connections to accept between two checks for a stop, because clients may connect constantly.
constexpr int kAcceptedAtOnce = 64;
// Interval between attempts to accept when no file descriptor is available, in milliseconds.
constexpr int kDescriptorPollMs = 50;

absl::Status SystemError(absl::string_view what) {
  return absl::UnavailableError(absl::StrCat(what, ": ", std::strerror(errno)));
}

// Interval of log lines about refused connections.
constexpr absl::Duration kWarningInterval = absl::Seconds(10);

// Raises the soft limit of open files to kDescriptorsMax, or to the hard limit if that is lower.
void RaiseDescriptorLimit() {
  rlimit files = {};
  if (getrlimit(RLIMIT_NOFILE, &files) == 0 && files.rlim_cur < Listener::kDescriptorsMax) {
    files.rlim_cur = std::min<rlim_t>(Listener::kDescriptorsMax, files.rlim_max);
    setrlimit(RLIMIT_NOFILE, &files);
  }
}

// Number of descriptors that connections may take.
rlim_t ConnectionDescriptors() {
  rlimit files = {};
  getrlimit(RLIMIT_NOFILE, &files);
  const rlim_t all = std::min<rlim_t>(files.rlim_cur, Listener::kDescriptorsMax);
  return all - all / 8;
}

// Returns device and inode of the file at `path`; zeros: there is none.
std::pair<dev_t, ino_t> FileAt(const std::string& path) {
  struct stat status = {};
  return lstat(path.c_str(), &status) == 0 ? std::pair(status.st_dev, status.st_ino)
                                           : std::pair<dev_t, ino_t>();
}

// Opens a socket that listens on `address`.
absl::StatusOr<int> ListeningSocket(const sockaddr* address, socklen_t length) {
  const int made = socket(address->sa_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (made < 0) {
    return SystemError("socket");
  }
  absl::Cleanup close_made = [made] { close(made); };
  const int on = 1;
  if (address->sa_family != AF_UNIX) {
    setsockopt(made, SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on));
    setsockopt(made, IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on));  // its connections inherit it
  }
  if (address->sa_family == AF_INET6) {
    // "[::]" means all addresses of the machine, including IPv4.
    const int off = 0;
    setsockopt(made, IPPROTO_IPV6, IPV6_V6ONLY, &off, sizeof(off));
  }
  if (bind(made, address, length) != 0) {
    return SystemError("bind");
  }
  if (listen(made, kWaitingMax) != 0) {
    return SystemError("listen");
  }
  std::move(close_made).Cancel();
  return made;
}

uint16_t PortOf(int socket) {
  sockaddr_storage bound = {};
  socklen_t length = sizeof(bound);
  getsockname(socket, reinterpret_cast<sockaddr*>(&bound), &length);
  return ntohs(bound.ss_family == AF_INET6 ? reinterpret_cast<sockaddr_in6*>(&bound)->sin6_port
                                           : reinterpret_cast<sockaddr_in*>(&bound)->sin_port);
}

void SetPort(uint16_t port, sockaddr* address) {
  if (address->sa_family == AF_INET6) {
    reinterpret_cast<sockaddr_in6*>(address)->sin6_port = htons(port);
  } else {
    reinterpret_cast<sockaddr_in*>(address)->sin_port = htons(port);
  }
}

bool SomebodyListensAt(const sockaddr_un& address) {
  const int asking = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const absl::Cleanup close_asking = [asking] { close(asking); };
  return connect(asking, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0;
}

}  // namespace

absl::StatusOr<std::unique_ptr<Listener>> Listener::Listen(const Address& address) {
  RaiseDescriptorLimit();
  std::unique_ptr<Listener> listener(new Listener());
  absl::Status status = address.unix_path.empty() ? listener->ListenOnHost(address)
                                                  : listener->ListenOnPath(address.unix_path);
  status.Update(listener->OpenStopPipe());
  if (!status.ok()) {
    return status;
  }
  return listener;
}

absl::StatusOr<std::unique_ptr<Listener>> Listener::ListenInternal() {
  std::unique_ptr<Listener> listener(new Listener());
  absl::Status status = listener->ListenOnAbstractName();
  status.Update(listener->OpenStopPipe());
  if (!status.ok()) {
    return status;
  }
  return listener;
}

absl::Status Listener::OpenStopPipe() {
  return pipe2(stop_, O_CLOEXEC) == 0 ? absl::OkStatus() : SystemError("pipe");
}

absl::Status Listener::ListenOnHost(const Address& address) {
  addrinfo hints = {};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE;
  addrinfo* found = nullptr;
  const int error =
      getaddrinfo(address.host.c_str(), std::to_string(address.port).c_str(), &hints, &found);
  if (error != 0) {
    return absl::UnavailableError(
        absl::StrCat("host '", address.host, "' cannot be resolved: ", gai_strerror(error)));
  }
  const absl::Cleanup free_found = [found] { freeaddrinfo(found); };
  // A name may have several addresses. All use the same port; listening on one of them is
  // sufficient.
  absl::Status first_error;
  for (addrinfo* one = found; one != nullptr; one = one->ai_next) {
    if (address.port == 0 && port_ != 0) {
      SetPort(port_, one->ai_addr);
    }
    const absl::StatusOr<int> listening = ListeningSocket(one->ai_addr, one->ai_addrlen);
    if (listening.ok()) {
      sockets_.push_back(*listening);
      port_ = PortOf(*listening);
    } else {
      first_error.Update(listening.status());
    }
  }
  return sockets_.empty() ? first_error : absl::OkStatus();
}

absl::Status Listener::ListenOnPath(const std::string& path) {
  sockaddr_un address = {};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof(address.sun_path)) {
    return absl::UnavailableError(absl::StrCat(
        "the path has ", path.size(), " characters, allowed: ", sizeof(address.sun_path) - 1));
  }
  path.copy(address.sun_path, path.size());
  struct stat status = {};
  if (stat(path.c_str(), &status) == 0 && S_ISSOCK(status.st_mode) && !SomebodyListensAt(address)) {
    unlink(path.c_str());
  }
  const absl::StatusOr<int> listening =
      ListeningSocket(reinterpret_cast<const sockaddr*>(&address), sizeof(address));
  if (!listening.ok()) {
    return listening.status();
  }
  sockets_.push_back(*listening);
  path_ = path;
  path_file_ = FileAt(path);
  return absl::OkStatus();
}

absl::Status Listener::ListenOnAbstractName() {
  // The kernel assigns a free abstract name, which begins with a byte 0 and has no file.
  sockaddr_un address = {};
  address.sun_family = AF_UNIX;
  const absl::StatusOr<int> listening =
      ListeningSocket(reinterpret_cast<const sockaddr*>(&address), sizeof(address.sun_family));
  if (!listening.ok()) {
    return listening.status();
  }
  sockets_.push_back(*listening);
  socklen_t size = sizeof(address);
  if (getsockname(*listening, reinterpret_cast<sockaddr*>(&address), &size) != 0) {
    return SystemError("getsockname");
  }
  const size_t name_begin = offsetof(sockaddr_un, sun_path) + 1;
  internal_target_ =
      absl::StrCat("unix-abstract:", absl::string_view(address.sun_path + 1, size - name_begin));
  return absl::OkStatus();
}

Listener::~Listener() {
  StopAccepting();
  for (const int open : stop_) {
    if (open >= 0) {
      close(open);
    }
  }
  if (!path_.empty() && FileAt(path_) == path_file_) {
    unlink(path_.c_str());
  }
  // Last: while the socket is open, no other server considers the path stale and removes it.
  for (const int listening : sockets_) {
    close(listening);
  }
}

void Listener::StopAccepting() {
  if (!thread_.joinable()) {
    return;
  }
  const char byte = 0;
  while (write(stop_[1], &byte, 1) < 0 && errno == EINTR) {
  }
  thread_.join();
}

void Listener::Start(Take take) {
  take_ = std::move(take);
  thread_ = std::thread([this] { AcceptUntilStopped(); });
}

void Listener::AcceptUntilStopped() {
  std::vector<pollfd> waits = {{stop_[0], POLLIN, 0}};
  for (const int listening : sockets_) {
    waits.push_back({listening, POLLIN, 0});
  }
  while (poll(waits.data(), waits.size(), -1) >= 0 || errno == EINTR) {
    bool has_descriptors = true;
    for (size_t i = 1; i < waits.size(); ++i) {
      if (waits[i].revents != 0) {
        has_descriptors = AcceptFrom(waits[i].fd) && has_descriptors;
      }
    }
    // Waiting connections keep the sockets readable, so poll would return immediately.
    if (!has_descriptors) {
      poll(waits.data(), 1, kDescriptorPollMs);
    }
    if (waits[0].revents != 0) {
      return;
    }
  }
}

bool Listener::AcceptFrom(int listening) {
  for (int i = 0; i < kAcceptedAtOnce; ++i) {
    const int connection = accept4(listening, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (connection < 0) {
      return errno != EMFILE && errno != ENFILE && errno != ENOBUFS && errno != ENOMEM;
    }
    if (!IsAllowed(connection) || !HasRoomFor(connection)) {
      close(connection);
      continue;
    }
    take_(listening, connection);
  }
  return true;
}

// The kernel assigns the lowest free descriptor, so a high one means that many are in use.
bool Listener::HasRoomFor(int connection) {
  const rlim_t max = ConnectionDescriptors();
  if (static_cast<rlim_t>(connection) < max) {
    return true;
  }
  if (const absl::Time now = SteadyNow(); now >= next_warning_) {
    next_warning_ = now + kWarningInterval;
    LogEvent(LogLevel::kWarning, "connections_refused",
             {{"message", absl::StrCat("connections take all of their ", max, " descriptors")}});
  }
  return false;
}

bool Listener::IsAllowed(int connection) const {
  if (internal_target_.empty()) {
    return true;
  }
  ucred peer = {};
  socklen_t size = sizeof(peer);
  return getsockopt(connection, SOL_SOCKET, SO_PEERCRED, &peer, &size) == 0 && peer.pid == getpid();
}

}  // namespace procgen
