#ifndef SERVER_WEB_WEB_SERVER_H_
#define SERVER_WEB_WEB_SERVER_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "procgen_client/client.h"
#include "server/net/tls_files.h"

namespace procgen::web {

struct WebOptions {
  std::string address;                     // "HOST:PORT"; port 0: any that is free
  std::vector<std::string> allowed_hosts;  // further names by which pages may be asked for
  int32_t viewers_max = 64;                // pages that are open at a time
  std::shared_ptr<TlsFiles> tls;           // null: plain text
  bool requires_token = false;             // the server asks its callers for tokens
  std::string version;                     // of the server
  // To the server itself, within the process.
  std::shared_ptr<grpc::Channel> channel;
  // All pools, whoever owns them.
  std::function<std::vector<procgen::v1::Pool>()> list_pools;
};

// Serves the pages and what they ask for, in threads of its own. Threads: one at a time.
class WebServer {
 public:
  // Errors: UNAVAILABLE the address cannot be listened on.
  static absl::StatusOr<std::unique_ptr<WebServer>> Start(const WebOptions& options);
  // Tells the pages that the server stops, ends what they play, and waits for it: two seconds or so
  // where a page does not read.
  virtual ~WebServer() = default;

  // As a browser takes it, with the port that was bound: "http://127.0.0.1:8080/".
  virtual const std::string& url() const = 0;
};

}  // namespace procgen::web

#endif  // SERVER_WEB_WEB_SERVER_H_
