#include "server/net/connections.h"

#include <fcntl.h>
#include <netinet/in.h>
#include <sys/stat.h>
#include <unistd.h>

#include <iterator>
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
constexpr size_t kNetworkBytes = 8;    // size of an IPv6 address's /64 network
constexpr size_t kMappedBytesAt = 12;  // where an IPv4-mapped IPv6 address has the IPv4 one

// Returns the inode of an open file; 0: it is not open. Not by fstat, for which ThreadSanitizer
// would report that another thread may close the file or reuse its descriptor.
uint64_t InodeOf(int file) {
  struct statx status = {};
  return statx(file, "", AT_EMPTY_PATH, STATX_INO, &status) == 0 ? status.stx_ino : 0;
}

// The bytes of an address that share a limit; empty: a unix socket.
std::string SharedPartOf(const sockaddr* address) {
  if (address->sa_family == AF_INET) {
    const in_addr& ipv4 = reinterpret_cast<const sockaddr_in*>(address)->sin_addr;
    return {reinterpret_cast<const char*>(&ipv4), sizeof(ipv4)};
  }
  if (address->sa_family == AF_INET6) {
    const in6_addr& ipv6 = reinterpret_cast<const sockaddr_in6*>(address)->sin6_addr;
    const auto* const bytes = reinterpret_cast<const char*>(ipv6.s6_addr);
    return IN6_IS_ADDR_V4MAPPED(&ipv6) ? std::string(bytes + kMappedBytesAt, sizeof(in_addr))
                                       : std::string(bytes, kNetworkBytes);
  }
  return "";
}

// Shuts down a connection. gRPC may close the descriptor at any time, and it may then refer to
// another file. So this works on a duplicate whose inode it checks first.
void ShutDown(int connection, uint64_t inode) {
  const int same = fcntl(connection, F_DUPFD_CLOEXEC, 0);
  if (same < 0) {
    return;
  }
  const absl::Cleanup close_same = [same] { close(same); };
  if (InodeOf(same) == inode) {
    shutdown(same, SHUT_RDWR);
  }
}

}  // namespace

bool Connections::Add(int connection, const sockaddr* address) {
  std::string shared_part = SharedPartOf(address);
  absl::MutexLock lock(&mutex_);
  // The descriptor has been reused, so its earlier connection is closed.
  if (const auto it = table_.find(connection); it != table_.end()) {
    Remove(it);
  }
  if (!HasRoom(shared_part)) {
    return false;
  }
  ++counts_[shared_part];
  table_[connection] = {.inode = InodeOf(connection), .address = std::move(shared_part)};
  return true;
}

bool Connections::IsWithin(const std::string& address) {
  const size_t free_count = count_max_ - table_.size();
  if (free_count == 0 || address.empty()) {
    return free_count > 0;
  }
  const auto count = counts_.find(address);
  return count == counts_.end() || count->second < free_count;
}

bool Connections::HasRoom(const std::string& address) {
  if (!IsWithin(address)) {
    RemoveClosed();
  }
  const bool has_room = IsWithin(address);
  const absl::Time now = SteadyNow();
  if (!has_room && now >= next_warning_) {
    next_warning_ = now + kWarningInterval;
    LogEvent(LogLevel::kWarning, "connections_refused",
             {{"message", absl::StrCat("there are ", table_.size(),
                                       " connections, limit connection_count_max is ", count_max_,
                                       "; one address has at most as many as remain free")}});
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
  const auto count = counts_.find(it->second.address);
  if (--count->second == 0) {
    counts_.erase(count);
  }
  return table_.erase(it);
}

void Connections::ShutDownAll() {
  absl::MutexLock lock(&mutex_);
  for (const auto& [descriptor, connection] : table_) {
    ShutDown(descriptor, connection.inode);
  }
}

}  // namespace procgen
