#ifndef SERVER_NET_TLS_FILES_H_
#define SERVER_NET_TLS_FILES_H_

#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "server/net/watched_file.h"

namespace procgen {

// Where the server's certificate (a chain, its own first), its key, and the certificates of those
// who vouch for clients are; all PEM.
struct TlsPaths {
  std::string certificate;
  std::string key;
  std::string client_ca;  // empty: clients are asked for no certificate
};

// The files that TLS is spoken with. They are checked with each new connection, and read again
// after they have changed; if they are broken then (also while one of a pair is replaced before the
// other), that is told in the log and what was read before stays in use.
// Threads: any method from any thread.
class TlsFiles {
 public:
  // Errors: a file cannot be read, or holds no certificate or key, or they are no pair; the message
  // names flag and file.
  static absl::StatusOr<std::shared_ptr<TlsFiles>> Open(const TlsPaths& paths);

  // Clients must show a certificate (mutual TLS).
  bool asks_clients() const { return asks_clients_; }

  struct Contents {
    std::string certificate;
    std::string key;
    std::string client_ca;  // empty: clients are asked for no certificate
  };
  // What is to be used at this moment, and a number that is another whenever the contents are; at
  // least 1.
  std::pair<Contents, int64_t> Current();

 private:
  explicit TlsFiles(const TlsPaths& paths);
  // Reads again what has changed.
  void Refresh() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::StatusOr<Contents> Read() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const bool asks_clients_;
  absl::Mutex mutex_;
  WatchedFile certificate_ ABSL_GUARDED_BY(mutex_);
  WatchedFile key_ ABSL_GUARDED_BY(mutex_);
  WatchedFile client_ca_ ABSL_GUARDED_BY(mutex_);
  Contents contents_ ABSL_GUARDED_BY(mutex_);
  int64_t version_ ABSL_GUARDED_BY(mutex_) = 1;  // of contents_
};

}  // namespace procgen

#endif  // SERVER_NET_TLS_FILES_H_
