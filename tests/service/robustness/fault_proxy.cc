#include "tests/service/robustness/fault_proxy.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <list>
#include <random>
#include <tuple>
#include <utility>
#include <vector>

namespace procgen {
namespace {

using Steady = std::chrono::steady_clock;

constexpr size_t kBufferBytes = 64 << 10;
constexpr int kHoldMsMax = 30;

sockaddr_in Loopback(int port) {
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<uint16_t>(port));
  return address;
}

int NewSocket() { return socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0); }

// Bytes in one direction.
struct Flow {
  int from = -1;
  int to = -1;
  std::string buffer{};
  bool ended = false;     // the source has closed its side
  bool shut = false;      // the end was forwarded
  bool discards = false;  // received bytes are dropped
};

// A client's connection and its connection to the server.
class Link {
 public:
  Link(int client, int server, int64_t bytes_left)
      : client_(client), server_(server), bytes_left_(bytes_left) {
    flows_[0] = {.from = client, .to = server};
    flows_[1] = {.from = server, .to = client};
  }
  ~Link() {
    close(client_);
    close(server_);
  }
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  void AddTo(std::vector<pollfd>* polled) const {
    for (const Flow& flow : flows_) {
      if (!flow.ended && flow.buffer.size() < kBufferBytes) {
        polled->push_back({flow.from, POLLIN, 0});
      }
      if (!flow.buffer.empty()) {
        polled->push_back({flow.to, POLLOUT, 0});
      }
    }
  }

  bool IsHeld(Steady::time_point now) const { return now < held_until_; }
  Steady::time_point held_until() const { return held_until_; }
  // Cut the link after the hold.
  bool IsDoomed() const { return is_doomed_; }

  // Forwards available bytes, at most `bytes_left_` of them if `counts`. Returns false if the
  // connection ended.
  bool Pump(bool counts) {
    return std::all_of(flows_.begin(), flows_.end(),
                       [&](Flow& flow) { return Receive(&flow) && Send(&flow, counts); }) &&
           !(flows_[0].shut && flows_[1].shut);
  }
  // Whether a fault is due.
  bool IsSpent() const { return bytes_left_ == 0; }
  // Time of the last forwarded byte or fault.
  Steady::time_point active_at() const { return active_at_; }
  void NoteActivity(Steady::time_point now) { active_at_ = now; }
  void Allow(int64_t bytes) { bytes_left_ = bytes; }

  void Cut() const {
    const linger reset = {.l_onoff = 1, .l_linger = 0};
    setsockopt(client_, SOL_SOCKET, SO_LINGER, &reset, sizeof(reset));
    setsockopt(server_, SOL_SOCKET, SO_LINGER, &reset, sizeof(reset));
  }
  void Hold(Steady::time_point until, bool is_doomed) {
    held_until_ = until;
    is_doomed_ = is_doomed;
  }
  void HalfClose(size_t which) {
    Flow& flow = flows_[which];
    shutdown(flow.to, SHUT_WR);
    flow.discards = true;
    flow.shut = true;
    flow.buffer.clear();
  }

 private:
  static bool Receive(Flow* flow) {
    std::array<char, kBufferBytes> bytes;
    while (!flow->ended && flow->buffer.size() < kBufferBytes) {
      const ssize_t count = recv(flow->from, bytes.data(), bytes.size(), 0);
      if (count < 0) {
        return errno == EAGAIN;
      }
      flow->ended = count == 0;
      if (!flow->discards) {
        flow->buffer.append(bytes.data(), static_cast<size_t>(count));
      }
    }
    return true;
  }

  bool Send(Flow* flow, bool counts) {
    while (!flow->buffer.empty()) {
      size_t size = flow->buffer.size();
      if (counts) {
        size = std::min(size, static_cast<size_t>(bytes_left_));
      }
      if (size == 0) {
        return true;
      }
      const ssize_t count = send(flow->to, flow->buffer.data(), size, MSG_NOSIGNAL);
      if (count < 0) {
        return errno == EAGAIN;
      }
      active_at_ = Steady::now();
      flow->buffer.erase(0, static_cast<size_t>(count));
      bytes_left_ -= counts ? count : 0;
    }
    if (flow->ended && !flow->shut) {
      shutdown(flow->to, SHUT_WR);
      flow->shut = true;
    }
    return true;
  }

  const int client_;
  const int server_;
  std::array<Flow, 2> flows_;
  int64_t bytes_left_;  // until the next fault
  Steady::time_point active_at_ = Steady::now();
  Steady::time_point held_until_;
  bool is_doomed_ = false;
};

}  // namespace

// The poll loop, on its own thread.
class FaultProxy::Loop {
 public:
  Loop(FaultProxy* proxy, const Options& options, int wake_fd)
      : proxy_(proxy),
        options_(options),
        random_(options.seed),
        wake_fd_(wake_fd),
        listener_(NewSocket()) {
    sockaddr_in address = Loopback(0);
    socklen_t size = sizeof(address);
    if (bind(listener_, reinterpret_cast<sockaddr*>(&address), size) != 0 ||
        listen(listener_, SOMAXCONN) != 0 ||
        getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size) != 0) {
      std::abort();
    }
    port_ = ntohs(address.sin_port);
    target_port_ = std::stoi(options.target.substr(options.target.rfind(':') + 1));
  }
  ~Loop() { close(listener_); }
  Loop(const Loop&) = delete;
  Loop& operator=(const Loop&) = delete;

  int port() const { return port_; }

  void Run() {
    while (Wait()) {
      if (proxy_->frozen_) {
        continue;
      }
      Accept();
      const Steady::time_point now = Steady::now();
      for (auto link = links_.begin(); link != links_.end();) {
        link = Tend(&*link, now) ? std::next(link) : links_.erase(link);
      }
    }
  }

 private:
  // Waits for an event; returns false if the proxy stops.
  bool Wait() {
    std::vector<pollfd> polled = {{wake_fd_, POLLIN, 0}};
    if (proxy_->frozen_) {
      return Poll(&polled, -1);
    }
    polled.push_back({listener_, POLLIN, 0});
    const Steady::time_point now = Steady::now();
    Steady::time_point next = Steady::time_point::max();
    for (const Link& link : links_) {
      if (link.IsHeld(now)) {
        next = std::min(next, link.held_until());
        continue;
      }
      link.AddTo(&polled);
      if (HarmsSilence()) {
        next = std::min(next, link.active_at() + options_.silence_max);
      }
    }
    int timeout_ms = -1;
    if (next != Steady::time_point::max()) {
      const auto rest = std::chrono::ceil<std::chrono::milliseconds>(next - now).count();
      timeout_ms = static_cast<int>(std::max(int64_t{0}, int64_t{rest}));
    }
    return Poll(&polled, timeout_ms);
  }

  bool Poll(std::vector<pollfd>* polled, int timeout_ms) {
    poll(polled->data(), polled->size(), timeout_ms);
    eventfd_t woken = 0;
    eventfd_read(wake_fd_, &woken);
    return !proxy_->stops_;
  }

  void Accept() {
    while (true) {
      const int client = accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
      if (client < 0) {
        return;
      }
      const int server = NewSocket();
      const sockaddr_in address = Loopback(target_port_);
      // The connection is in progress: bytes wait until the socket is writable.
      std::ignore = connect(server, reinterpret_cast<const sockaddr*>(&address), sizeof(address));
      for (const int socket : {client, server}) {
        const int on = 1;
        setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on));
      }
      links_.emplace_back(client, server, NextFaultBytes());
    }
  }

  // Returns false if the connection ended.
  bool Tend(Link* link, Steady::time_point now) {
    if (link->IsHeld(now)) {
      return true;
    }
    if (link->IsDoomed()) {
      link->Cut();
      return false;
    }
    if (!link->Pump(proxy_->faults_)) {
      return false;
    }
    const bool was_silent = HarmsSilence() && now - link->active_at() >= options_.silence_max;
    return !(link->IsSpent() || was_silent) || Strike(link, now);
  }

  bool HarmsSilence() const {
    return proxy_->faults_ && options_.silence_max > std::chrono::milliseconds::zero();
  }

  bool Strike(Link* link, Steady::time_point now) {
    const auto until =
        now + std::chrono::milliseconds(std::uniform_int_distribution<>(1, kHoldMsMax)(random_));
    const int fault = std::uniform_int_distribution<>(0, 5)(random_);
    link->Allow(NextFaultBytes());
    link->NoteActivity(now);
    if (fault == 0) {
      link->Hold(until, /*is_doomed=*/false);
      return true;
    }
    ++proxy_->break_count_;
    switch (fault) {
      case 1:
        link->Hold(until, /*is_doomed=*/true);
        return true;
      case 2:
        link->HalfClose(0);
        return true;
      case 3:
        link->HalfClose(1);
        return true;
      case 4:
        return false;
      default:
        link->Cut();
        return false;
    }
  }

  int64_t NextFaultBytes() {
    return std::uniform_int_distribution<int64_t>(1, 2 * options_.bytes_between_faults)(random_);
  }

  FaultProxy* const proxy_;
  const Options options_;
  std::mt19937 random_;
  const int wake_fd_;
  const int listener_;
  int port_ = 0;
  int target_port_ = 0;
  std::list<Link> links_;
};

FaultProxy::FaultProxy(const Options& options) : wake_fd_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  loop_ = std::make_unique<Loop>(this, options, wake_fd_);
  address_ = "127.0.0.1:" + std::to_string(loop_->port());
  thread_ = std::thread([this] { loop_->Run(); });
}

void FaultProxy::SetFaults(bool enabled) {
  faults_ = enabled;
  eventfd_write(wake_fd_, 1);
}

void FaultProxy::Freeze() {
  frozen_ = true;
  eventfd_write(wake_fd_, 1);
}

FaultProxy::~FaultProxy() {
  stops_ = true;
  eventfd_write(wake_fd_, 1);
  thread_.join();
  close(wake_fd_);
}

}  // namespace procgen
