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

// The open connections of a listener: how many there may be, and what those may do whose callers
// have not been identified yet. gRPC bounds none of this, so the sockets are watched from outside:
// a connection that exceeds a bound is shut down.
//
// A connection is identified once a call on it was (CallAccounting); then only the total counts.
// Before that it may be silent, refused, and send bytes only within the bounds below, and hold a
// quarter of the connections together with its like. One address has at most as many connections as
// are left, identified or not, so whatever it does there is room for another address. Sockets of
// the file system have no address: their connections count as identified. Threads: any method from
// any thread.
class Connections {
 public:
  // Calls of one connection that ask for no token (health, reflection) under way, and calls that
  // were refused or given up by their caller, before it is identified.
  static constexpr int kOpenCallCountMax = 8;
  static constexpr int kRefusedCallCountMax = 100;
  // Bytes that it may send before it is identified, and more for each of its calls. The first
  // flight of an HTTP/2 client has up to 64 KiB besides the headers.
  static constexpr int64_t kBytesMax = 80 << 10;
  static constexpr int64_t kBytesPerCallMax = 1 << 10;
  // How often these are inspected.
  static constexpr absl::Duration kInspectionInterval = absl::Milliseconds(10);

  // `silence_max`: until a connection without a call is identified. Infinite: nothing is identified
  // here, and no more than the number of connections is bounded.
  Connections(int32_t count_max, absl::Duration silence_max);

  size_t count_max() const { return count_max_; }

  // Takes in an accepted connection. False: there is no room; the caller closes it.
  bool Add(int connection, const sockaddr* address) ABSL_LOCKS_EXCLUDED(mutex_);

  // What calls tell of their connection. `peer`: as gRPC names it; one that is not known here, as
  // of a socket in the file system, is ignored.
  void Identify(const std::string& peer) ABSL_LOCKS_EXCLUDED(mutex_);
  void CountRefused(const std::string& peer) ABSL_LOCKS_EXCLUDED(mutex_);
  // A call that asks for no token. False: there are too many, and it counts as refused.
  bool BeginCall(const std::string& peer) ABSL_LOCKS_EXCLUDED(mutex_);
  // `is_answered`: else it counts as refused.
  void EndCall(const std::string& peer, bool is_answered) ABSL_LOCKS_EXCLUDED(mutex_);

  // Shuts down unidentified connections that exceed a bound. Whether there are any left.
  bool Inspect() ABSL_LOCKS_EXCLUDED(mutex_);
  // Shuts down all.
  void ShutDownAll() ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  struct Connection {
    uint64_t inode = 0;   // of its socket; another one: the descriptor is another file's by now
    std::string peer;     // as gRPC names it; empty: a socket of the file system
    std::string address;  // that it shares a bound with: of IPv6, the network of 64 bits
    bool is_identified = false;
    int open_call_count = 0;
    int call_count = 0;
    int refused_call_count = 0;
    absl::Time last_activity;  // since then it has had no call
  };
  struct Counts {
    size_t all = 0;
    size_t unidentified = 0;
  };
  using Table = std::unordered_map<int, Connection>;

  // Null: none.
  Connection* Find(const std::string& peer) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool HasRoom(const std::string& address) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool IsWithin(const std::string& address) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void SetIdentified(Connection* connection) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  Table::iterator Remove(Table::iterator it) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Removes those that were closed, unless it was done a moment ago.
  void RemoveClosed() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // What it exceeds; empty: nothing.
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
