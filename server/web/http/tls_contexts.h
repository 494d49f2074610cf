#ifndef SERVER_WEB_HTTP_TLS_CONTEXTS_H_
#define SERVER_WEB_HTTP_TLS_CONTEXTS_H_

#include <cstdint>
#include <memory>

#include "boost/asio/ssl/context.hpp"
#include "server/net/tls_files.h"

namespace procgen::web {

// Provides the TLS context of new connections, from the current contents of the files that gRPC
// uses. Threads: compatible (one at a time).
class TlsContexts {
 public:
  // Null `files`: plain text.
  explicit TlsContexts(std::shared_ptr<TlsFiles> files) : files_(std::move(files)) {}

  // Returns null for plain text.
  std::shared_ptr<boost::asio::ssl::context> Current();

 private:
  const std::shared_ptr<TlsFiles> files_;
  int64_t version_ = 0;
  std::shared_ptr<boost::asio::ssl::context> context_;
};

}  // namespace procgen::web

#endif  // SERVER_WEB_HTTP_TLS_CONTEXTS_H_
