#ifndef SERVER_WEB_HTTP_TLS_CONTEXTS_H_
#define SERVER_WEB_HTTP_TLS_CONTEXTS_H_

#include <cstdint>
#include <memory>

#include "boost/asio/ssl/context.hpp"
#include "server/net/tls_files.h"

namespace procgen::web {

// What TLS is spoken with on new connections: the files of gRPC's, as they are at the time.
// Threads: compatible (one at a time).
class TlsContexts {
 public:
  // `files`: null, plain text.
  explicit TlsContexts(std::shared_ptr<TlsFiles> files) : files_(std::move(files)) {}

  // Null: plain text.
  std::shared_ptr<boost::asio::ssl::context> Current();

 private:
  const std::shared_ptr<TlsFiles> files_;
  int64_t version_ = 0;
  std::shared_ptr<boost::asio::ssl::context> context_;
};

}  // namespace procgen::web

#endif  // SERVER_WEB_HTTP_TLS_CONTEXTS_H_
