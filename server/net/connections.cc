#include "server/net/connections.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <linux/tcp.h>
#include <netinet/in.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "absl/cleanup/cleanup.h"
#include "absl/strings/str_cat.h"
#include "server/concurrency/steady_time.h"
#include "server/logging/event_log.h"

namespace procgen {
namespace {

// Looking for closed connections takes at most one part in kRemovalShare of the time.
constexpr int kRemovalShare = 20;
constexpr absl::Duration kWarningInterval = absl::Minutes(1);
// Allows several clients to connect at once even if connection_count_max is small.
constexpr size_t kUnidentifiedCountMin = 16;
constexpr int kNetworkBytes = 8;  // size of an IPv6 address's /64 network

// Returns the inode of an open file; 0: it is not open. Not by fstat, for which ThreadSanitizer
// would report that another thread may close the file or reuse its descriptor.
uint64_t InodeOf(int file) {
  struct statx status = {};
  return statx(file, "", AT_EMPTY_PATH, STATX_INO, &status) == 0 ? status.stx_ino : 0;
}

// An address in gRPC's format, and the part of it that shares a limit.
struct Names {
  std::string peer;
  std::string address;
};

Names NamesOf4(const in_addr& address, in_port_t port) {
  char text[INET_ADDRSTRLEN] = {};
  inet_ntop(AF_INET, &address, text, sizeof(text));
  return {absl::StrCat("ipv4:", text, ":", ntohs(port)), text};
}

Names NamesOf6(const sockaddr_in6& whole) {
  if (IN6_IS_ADDR_V4MAPPED(&whole.sin6_addr)) {
    in_addr inner = {};
    std::memcpy(&inner, whole.sin6_addr.s6_addr + 12, sizeof(inner));
    return NamesOf4(inner, whole.sin6_port);
  }
  char text[INET6_ADDRSTRLEN] = {};
  inet_ntop(AF_INET6, &whole.sin6_addr, text, sizeof(text));
  // gRPC adds the scope, if there is one, and escapes as in a URI.
  const std::string scope =
      whole.sin6_scope_id == 0 ? "" : absl::StrCat("%25", whole.sin6_scope_id);
  return {absl::StrCat("ipv6:%5B", text, scope, "%5D:", ntohs(whole.sin6_port)),
          std::string(reinterpret_cast<const char*>(whole.sin6_addr.s6_addr), kNetworkBytes)};
}

Names NamesOf(const sockaddr* address) {
  if (address->sa_family == AF_INET) {
    const auto* whole = reinterpret_cast<const sockaddr_in*>(address);
    return NamesOf4(whole->sin_addr, whole->sin_port);
  }
  if (address->sa_family == AF_INET6) {
    return NamesOf6(*reinterpret_cast<const sockaddr_in6*>(address));
  }
  return {};
}

int64_t ReceivedBytes(int connection) {
  tcp_info status = {};
  socklen_t size = sizeof(status);
  return getsockopt(connection, IPPROTO_TCP, TCP_INFO, &status, &size) == 0
             ? static_cast<int64_t>(status.tcpi_bytes_received)
             : 0;
}

// Shuts down a connection and discards the received bytes. gRPC may close the descriptor at any
// time, and it may then refer to another file. So this works on a duplicate whose inode it checks
// first.
void ShutDown(int connection, uint64_t inode) {
  const int same = fcntl(connection, F_DUPFD_CLOEXEC, 0);
  if (same < 0) {
    return;
  }
  const absl::Cleanup close_same = [same] { close(same); };
  if (InodeOf(same) != inode) {
    return;
  }
  shutdown(same, SHUT_RDWR);
  constexpr size_t kDiscardedAtOnce = size_t{1} << 20;
  while (recv(same, nullptr, kDiscardedAtOnce, MSG_TRUNC | MSG_DONTWAIT) > 0) {
  }
}

}  // namespace

Connections::Connections(int32_t count_max, absl::Duration silence_max)
    : count_max_(static_cast<size_t>(count_max)),
      unidentified_count_max_(std::max(count_max_ / 4, kUnidentifiedCountMin)),
      silence_max_(silence_max) {}

bool Connections::Add(int connection, const sockaddr* address) {
  Names names = NamesOf(address);
  absl::MutexLock lock(&mutex_);
  // The descriptor has been reused, so its earlier connection is closed.
  if (const auto it = table_.find(connection); it != table_.end()) {
    Remove(it);
  }
  if (!HasRoom(names.address)) {
    return false;
  }
  const bool is_identified = names.peer.empty() || silence_max_ == absl::InfiniteDuration();
  Counts& counts = by_address_[names.address];
  ++counts.all;
  if (!is_identified) {
    ++counts.unidentified;
    ++unidentified_count_;
  }
  by_peer_[names.peer] = connection;
  table_[connection] = {.inode = InodeOf(connection),
                        .peer = std::move(names.peer),
                        .address = std::move(names.address),
                        .is_identified = is_identified,
                        .last_activity = SteadyNow()};
  return true;
}

bool Connections::IsWithin(const std::string& address) {
  if (table_.size() >= count_max_) {
    return false;
  }
  if (address.empty()) {
    return true;
  }
  const Counts& counts = by_address_[address];
  return counts.all < count_max_ - table_.size() &&
         counts.unidentified + unidentified_count_ < unidentified_count_max_;
}

bool Connections::HasRoom(const std::string& address) {
  if (!IsWithin(address)) {
    RemoveClosed();
  }
  const bool has_room = IsWithin(address);
  const absl::Time now = SteadyNow();
  if (!has_room && now >= next_warning_) {
    next_warning_ = now + kWarningInterval;
    LogEvent(
        LogLevel::kWarning, "connections_refused",
        {{"message",
          absl::StrCat("there are ", table_.size(), " connections, of which ", unidentified_count_,
                       " are unidentified, limit connection_count_max is ", count_max_)}});
  }
  return has_room;
}

void Connections::RemoveClosed() {
  const absl::Time begin = SteadyNow();
  if (begin < next_removal_) {
    return;
  }
  for (auto it = table_.begin(); it != table_.end();) {
    it = InodeOf(it->first) == it->second.inode ? std::next(it) : Remove(it);
  }
  const absl::Time end = SteadyNow();
  next_removal_ = end + kRemovalShare * (end - begin);
}

Connections::Table::iterator Connections::Remove(Table::iterator it) {
  SetIdentified(&it->second);  // removes it from the counts of unidentified ones
  const auto counts = by_address_.find(it->second.address);
  if (--counts->second.all == 0) {
    by_address_.erase(counts);
  }
  const auto named = by_peer_.find(it->second.peer);
  if (named != by_peer_.end() && named->second == it->first) {
    by_peer_.erase(named);
  }
  return table_.erase(it);
}

void Connections::SetIdentified(Connection* connection) {
  if (!connection->is_identified) {
    connection->is_identified = true;
    --by_address_[connection->address].unidentified;
    --unidentified_count_;
  }
}

Connections::Connection* Connections::Find(const std::string& peer) {
  const auto it = by_peer_.find(peer);
  return it == by_peer_.end() || peer.empty() ? nullptr : &table_.find(it->second)->second;
}

void Connections::Identify(const std::string& peer) {
  absl::MutexLock lock(&mutex_);
  if (Connection* const connection = Find(peer); connection != nullptr) {
    SetIdentified(connection);
  }
}

void Connections::CountRefused(const std::string& peer) {
  absl::MutexLock lock(&mutex_);
  Connection* const connection = Find(peer);
  if (connection == nullptr || connection->is_identified) {
    return;
  }
  ++connection->call_count;
  connection->last_activity = SteadyNow();
  if (++connection->refused_call_count > kRefusedCallCountMax) {
    ShutDown(by_peer_[peer], connection->inode);
  }
}

bool Connections::BeginCall(const std::string& peer) {
  {
    absl::MutexLock lock(&mutex_);
    Connection* const connection = Find(peer);
    if (connection == nullptr) {
      return true;
    }
    if (connection->open_call_count < kOpenCallCountMax) {
      ++connection->open_call_count;
      ++connection->call_count;
      connection->last_activity = SteadyNow();
      return true;
    }
  }
  CountRefused(peer);
  return false;
}

void Connections::EndCall(const std::string& peer, bool is_answered) {
  {
    absl::MutexLock lock(&mutex_);
    Connection* const connection = Find(peer);
    if (connection == nullptr) {
      return;
    }
    // A new connection may have the same peer and no open calls.
    connection->open_call_count = std::max(connection->open_call_count - 1, 0);
    connection->last_activity = SteadyNow();
  }
  if (!is_answered) {
    CountRefused(peer);
  }
}

absl::string_view Connections::ExcessOf(int descriptor, const Connection& connection,
                                        absl::Time now) {
  if (connection.open_call_count == 0 && now - connection.last_activity > silence_max_) {
    return "no token within attach_timeout";
  }
  if (ReceivedBytes(descriptor) > kBytesMax + connection.call_count * kBytesPerCallMax) {
    return "too many bytes without a token";
  }
  return "";
}

bool Connections::Inspect() {
  absl::MutexLock lock(&mutex_);
  const absl::Time now = SteadyNow();
  if (unidentified_count_ == 0 || now < next_inspection_) {
    return unidentified_count_ > 0;
  }
  next_inspection_ = now + kInspectionInterval;
  for (auto it = table_.begin(); it != table_.end();) {
    const auto& [descriptor, connection] = *it;
    if (connection.is_identified) {
      ++it;
      continue;
    }
    if (InodeOf(descriptor) != connection.inode) {
      it = Remove(it);
      continue;
    }
    if (const absl::string_view excess = ExcessOf(descriptor, connection, now); !excess.empty()) {
      // Logged as debug only, because any client can cause any number of these lines.
      LogEvent(LogLevel::kDebug, "connection_shut_down",
               {{"peer", connection.peer}, {"message", std::string(excess)}});
      ShutDown(descriptor, connection.inode);
    }
    ++it;
  }
  return unidentified_count_ > 0;
}

void Connections::ShutDownAll() {
  absl::MutexLock lock(&mutex_);
  for (const auto& [descriptor, connection] : table_) {
    ShutDown(descriptor, connection.inode);
  }
}

}  // namespace procgen
