#ifndef SERVER_RPC_AUTH_TLS_CREDENTIALS_H_
#define SERVER_RPC_AUTH_TLS_CREDENTIALS_H_

#include <cstdint>
#include <memory>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "grpc/grpc_security.h"
#include "grpcpp/security/server_credentials.h"
#include "server/net/tls_files.h"

namespace procgen {

// gRPC server credentials for TLS with files that may be replaced at run time.
// Threads: any method from any thread.
class TlsCredentials {
 public:
  // `files` must not be null.
  explicit TlsCredentials(std::shared_ptr<TlsFiles> files) : files_(std::move(files)) {}

  // Returns the credentials of one server, which this object must outlive.
  std::shared_ptr<grpc::ServerCredentials> Make();

 private:
  static grpc_ssl_certificate_config_reload_status Fetch(
      void* credentials, grpc_ssl_server_certificate_config** config);
  grpc_ssl_certificate_config_reload_status Fetch(grpc_ssl_server_certificate_config** config);

  const std::shared_ptr<TlsFiles> files_;
  absl::Mutex mutex_;
  int64_t fetched_version_ ABSL_GUARDED_BY(mutex_) = 0;  // version of files_ that gRPC has
};

}  // namespace procgen

#endif  // SERVER_RPC_AUTH_TLS_CREDENTIALS_H_
