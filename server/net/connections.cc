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

// Of the time, at most one part in so many goes into finding closed connections.
constexpr int kRemovalShare = 20;
constexpr absl::Duration kWarningInterval = absl::Minutes(1);
// So that a server with few connections can still be reached by several clients at once.
constexpr size_t kUnidentifiedCountMin = 16;
constexpr int kNetworkBytes = 8;  // of an address of IPv6

// The inode of an open file; 0: it is not open. The file may be closed, and its number taken by
// another, at any time, which ThreadSanitizer would report of fstat.
uint64_t InodeOf(int file) {
  struct statx facts = {};
  return statx(file, "", AT_EMPTY_PATH, STATX_INO, &facts) == 0 ? facts.stx_ino : 0;
}

// An address as gRPC writes it, and the part of it that shares a bound.
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
  // gRPC gives the scope of an address that has one, and escapes as in a URI.
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
  tcp_info facts = {};
  socklen_t size = sizeof(facts);
  return getsockopt(connection, IPPROTO_TCP, TCP_INFO, &facts, &size) == 0
             ? static_cast<int64_t>(facts.tcpi_bytes_received)
             : 0;
}

// Shuts a connection down and discards what has arrived on it. gRPC may close the descriptor at any
// time, so a duplicate is made and checked first: nobody else's file is touched.
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
  // The descriptor was free, so what had it is closed.
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
        {{"message", absl::StrCat("there are ", table_.size(), ", of which ", unidentified_count_,
                                  " have not shown who they are, limit connection_count_max "
                                  "is ",
                                  count_max_)}});
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
  SetIdentified(&it->second);  // no longer among the others
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
    // Of another connection that has come to the same peer since, there may be none.
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
    return "it has shown no token within attach_timeout";
  }
  if (ReceivedBytes(descriptor) > kBytesMax + connection.call_count * kBytesPerCallMax) {
    return "it has sent too much without showing a token";
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
      // Not louder, for anybody can make as many of these lines as they like.
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
