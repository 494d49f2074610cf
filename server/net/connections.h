#ifndef SERVER_NET_CONNECTIONS_H_
#define SERVER_NET_CONNECTIONS_H_

#include <sys/socket.h>
#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"

namespace procgen {

// Limits the open connections of a listener, in total and while their callers are unidentified.
// gRPC has no such limits, so the sockets are inspected from outside: a connection that exceeds a
// limit is shut down.
//
// A connection is identified once a call on it is (CallAccounting); then only the total counts.
// Before that the limits below apply to its silence, refused calls and bytes, and unidentified
// connections hold at most a quarter of the total. One address has at most as many connections as
// remain free, so there is always room for another address. Unix socket connections have no address
// and count as identified.
// Threads: any method from any thread.
class Connections {
 public:
  // Limits of an unidentified connection: calls without a token (health, reflection) in progress,
  // and calls that were refused or cancelled.
  static constexpr int kOpenCallCountMax = 8;
  static constexpr int kRefusedCallCountMax = 100;
  // Bytes that an unidentified connection may send: in total, and in addition for each call. The
  // first flight of an HTTP/2 client has up to 64 KiB besides the headers.
  static constexpr int64_t kBytesMax = 80 << 10;
  static constexpr int64_t kBytesPerCallMax = 1 << 10;
  // Interval of inspections of unidentified connections.
  static constexpr absl::Duration kInspectionInterval = absl::Milliseconds(10);

  // `silence_max`: how long an unidentified connection may have no call. Infinite: only the number
  // of connections is limited.
  Connections(int32_t count_max, absl::Duration silence_max);

  size_t count_max() const { return count_max_; }

  // Registers an accepted connection. False: the limit is reached; the caller closes it.
  bool Add(int connection, const sockaddr* address) ABSL_LOCKS_EXCLUDED(mutex_);

  // Reports from calls. `peer`: in gRPC's format; an unknown one, as of a unix socket, is ignored.
  void Identify(const std::string& peer) ABSL_LOCKS_EXCLUDED(mutex_);
  void CountRefused(const std::string& peer) ABSL_LOCKS_EXCLUDED(mutex_);
  // Begins a call without a token. False: too many are in progress, and it counts as refused.
  bool BeginCall(const std::string& peer) ABSL_LOCKS_EXCLUDED(mutex_);
  // Ends it. Not `is_answered`: it counts as refused.
  void EndCall(const std::string& peer, bool is_answered) ABSL_LOCKS_EXCLUDED(mutex_);

  // Shuts down unidentified connections that exceed a limit. Returns whether any remain.
  bool Inspect() ABSL_LOCKS_EXCLUDED(mutex_);
  // Shuts down all connections.
  void ShutDownAll() ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  struct Connection {
    uint64_t inode = 0;   // of its socket; if it differs, the descriptor has been reused
    std::string peer;     // in gRPC's format; empty: a unix socket
    std::string address;  // that the limit applies to; IPv6: its /64 network
    bool is_identified = false;
    int open_call_count = 0;
    int call_count = 0;
    int refused_call_count = 0;
    absl::Time last_activity;  // of its last call, or when it was accepted
  };
  struct Counts {
    size_t all = 0;
    size_t unidentified = 0;
  };
  using Table = std::unordered_map<int, Connection>;

  // Returns null if there is none.
  Connection* Find(const std::string& peer) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool HasRoom(const std::string& address) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool IsWithin(const std::string& address) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void SetIdentified(Connection* connection) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  Table::iterator Remove(Table::iterator it) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Removes closed connections, unless the last removal was very recent.
  void RemoveClosed() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // The limit that it exceeds; empty: none.
  absl::string_view ExcessOf(int descriptor, const Connection& connection, absl::Time now)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const size_t count_max_;
  const size_t unidentified_count_max_;
  const absl::Duration silence_max_;

  absl::Mutex mutex_;
  Table table_ ABSL_GUARDED_BY(mutex_);  // by descriptor; closed ones are removed when found
  std::unordered_map<std::string, int> by_peer_ ABSL_GUARDED_BY(mutex_);
  std::unordered_map<std::string, Counts> by_address_ ABSL_GUARDED_BY(mutex_);
  size_t unidentified_count_ ABSL_GUARDED_BY(mutex_) = 0;
  absl::Time next_removal_ ABSL_GUARDED_BY(mutex_) = absl::InfinitePast();
  absl::Time next_inspection_ ABSL_GUARDED_BY(mutex_) = absl::InfinitePast();
  absl::Time next_warning_ ABSL_GUARDED_BY(mutex_) = absl::InfinitePast();
};

}  // namespace procgen

#endif  // SERVER_NET_CONNECTIONS_H_
