#ifndef SERVER_WEB_HTTP_SITE_H_
#define SERVER_WEB_HTTP_SITE_H_

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/string_view.h"
#include "server/web/http/embedded_pages.h"

namespace procgen::web {

// The relevant parts of an HTTP request.
struct HttpRequestInfo {
  std::string method;
  std::string target;         // path and query
  std::string host;           // the header; empty: none, or more than one
  std::string origin;         // the header; empty: none, or more than one
  std::string if_none_match;  // the header; empty: none
  bool accepts_gzip = false;  // content may be compressed
  bool wants_socket = false;  // requests a WebSocket upgrade
  std::string local_host;     // local address of the connection, without port
  bool is_secure = false;     // the connection uses TLS
};

inline constexpr int kSwitchingProtocols = 101;

// An HTTP response.
struct Reply {
  int status = 0;
  std::string content_type;
  absl::string_view contents;  // of a page; static storage
  std::string text;            // replaces `contents` unless empty
  std::string etag;
  bool is_gzip = false;  // `contents` is compressed
};

// Maps requests to replies and checks host and origin. Threads: any method from any thread.
class Site {
 public:
  // `allowed_hosts`: host names that requests may use in addition to localhost and the address of
  // the connection.
  Site(std::vector<std::string> allowed_hosts, const std::vector<EmbeddedPage>& pages);

  // The reply to a WebSocket upgrade request: status kSwitchingProtocols if it is accepted, else an
  // error.
  Reply ReplyToSocket(const HttpRequestInfo& request) const;
  // The reply to any other request.
  Reply ReplyToPage(const HttpRequestInfo& request) const;

  // Security headers of every reply: the Content-Security-Policy, no type sniffing, no framing, no
  // referrer.
  static std::vector<std::pair<std::string, std::string>> SafetyHeaders(
      const HttpRequestInfo& request);

 private:
  struct File {
    std::string content_type;
    absl::string_view contents;
    absl::string_view gzip_contents;  // empty: there is no smaller form
    std::string etag;
  };

  // Whether the Host header names this server. Prevents DNS rebinding: requests by a foreign name
  // that resolves to this server are rejected.
  bool IsOurHost(const HttpRequestInfo& request) const;
  static Reply WrongHost(const HttpRequestInfo& request);

  const std::vector<std::string> allowed_hosts_;
  std::map<std::string, File, std::less<>> files_;  // by path
};

}  // namespace procgen::web

#endif  // SERVER_WEB_HTTP_SITE_H_
