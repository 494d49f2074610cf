#ifndef SERVER_NET_CONNECTIONS_H_
#define SERVER_NET_CONNECTIONS_H_

#include <sys/socket.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <unordered_map>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"

namespace procgen {

// Limits the open connections of a listener. One address has at most as many as remain free, so
// there is always room for another address; unix socket connections have no address.
// gRPC owns the sockets and does not report that it closes one, so closed ones are found when a
// limit is reached.
// Threads: any method from any thread.
class Connections {
 public:
  explicit Connections(int64_t count_max) : count_max_(static_cast<size_t>(count_max)) {}

  // Registers an accepted connection. False: the limit is reached; the caller closes it.
  bool Add(int connection, const sockaddr* address) ABSL_LOCKS_EXCLUDED(mutex_);
  // Shuts down all connections.
  void ShutDownAll() ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  struct Connection {
    uint64_t inode = 0;   // of its socket; if it differs, the descriptor has been reused
    std::string address;  // that the limit applies to; IPv6: its /64 network; empty: none
  };
  using Table = std::unordered_map<int, Connection>;

  bool HasRoom(const std::string& address) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool IsWithin(const std::string& address) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  Table::iterator Remove(Table::iterator it) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Removes closed connections, unless the last removal was very recent.
  void RemoveClosed() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const size_t count_max_;

  absl::Mutex mutex_;
  Table table_ ABSL_GUARDED_BY(mutex_);                                     // by descriptor
  std::unordered_map<std::string, size_t> counts_ ABSL_GUARDED_BY(mutex_);  // by address
  absl::Time next_removal_ ABSL_GUARDED_BY(mutex_) = absl::InfinitePast();
  absl::Time next_warning_ ABSL_GUARDED_BY(mutex_) = absl::InfinitePast();
};

}  // namespace procgen

#endif  // SERVER_NET_CONNECTIONS_H_
