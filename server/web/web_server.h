#ifndef SERVER_WEB_WEB_SERVER_H_
#define SERVER_WEB_WEB_SERVER_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/net/tls_files.h"
#include "server/rpc/bridge/generic_call.h"

namespace procgen::web {

struct WebOptions {
  std::string address;                     // "HOST:PORT"; port 0: any free port
  std::vector<std::string> allowed_hosts;  // further host names that browsers may use
  int32_t viewers_max = 64;                // maximum number of open pages
  std::shared_ptr<TlsFiles> tls;           // null: plain text
  // Returns a stub of the server itself, for the calls of pages.
  std::function<std::unique_ptr<GenericStub>()> make_stub;
  int64_t request_bytes_max = 4 << 20;  // Limits.request_bytes_max of the server
};

// HTTP server of the pages, with its own threads. Threads: one at a time.
class WebServer {
 public:
  // Errors: UNAVAILABLE the address cannot be listened on.
  static absl::StatusOr<std::unique_ptr<WebServer>> Start(const WebOptions& options);
  // Begins to close, and waits until all sockets are closed and their calls have ended: about two
  // seconds if a page does not read.
  virtual ~WebServer() = default;

  // Accepts no more pages, closes the sockets of the open ones, and cancels their calls. Does not
  // wait for them.
  virtual void BeginClose() = 0;

  // URL with the bound port: "http://127.0.0.1:8080/".
  virtual const std::string& url() const = 0;
};

}  // namespace procgen::web

#endif  // SERVER_WEB_WEB_SERVER_H_
