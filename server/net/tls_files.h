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

// Paths of PEM files: the server's certificate chain (its own first), its key, and the authorities
// that sign client certificates.
struct TlsPaths {
  std::string certificate;
  std::string key;
  std::string client_ca;  // empty: clients are asked for no certificate
};

// The certificate files of TLS. They are checked at each new connection and read again after a
// change. If they are invalid then (also while a pair is replaced file by file), a warning is
// logged and the previous contents stay in use. Threads: any method from any thread.
class TlsFiles {
 public:
  // Errors: a file cannot be read, has no certificate or key, or they do not match; the message
  // names flag and file.
  static absl::StatusOr<std::shared_ptr<TlsFiles>> Open(const TlsPaths& paths);

  // Whether clients must present a certificate (mutual TLS).
  bool requires_client_certificate() const { return requires_client_certificate_; }

  struct Contents {
    std::string certificate;
    std::string key;
    std::string client_ca;  // empty: clients are asked for no certificate
  };
  // The current contents and their version, at least 1, which changes with the contents.
  std::pair<Contents, int64_t> Current();

 private:
  explicit TlsFiles(const TlsPaths& paths);
  // Reads changed files again.
  void Refresh() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::StatusOr<Contents> Read() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const bool requires_client_certificate_;
  absl::Mutex mutex_;
  WatchedFile certificate_ ABSL_GUARDED_BY(mutex_);
  WatchedFile key_ ABSL_GUARDED_BY(mutex_);
  WatchedFile client_ca_ ABSL_GUARDED_BY(mutex_);
  Contents contents_ ABSL_GUARDED_BY(mutex_);
  int64_t version_ ABSL_GUARDED_BY(mutex_) = 1;  // of contents_
};

}  // namespace procgen

#endif  // SERVER_NET_TLS_FILES_H_
