#ifndef SERVER_WEB_HTTP_SITE_H_
#define SERVER_WEB_HTTP_SITE_H_

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/string_view.h"
#include "server/web/http/embedded_pages.h"

namespace procgen::web {

// What a browser asks for, as far as it matters.
struct HttpRequestInfo {
  std::string method;
  std::string target;         // path, and what follows it
  std::string host;           // the header; empty: none, or more than one
  std::string origin;         // the header; empty: none, or more than one
  std::string if_none_match;  // the header; empty: none
  bool wants_socket = false;  // asks to go on as a WebSocket
  std::string local_host;     // the address that it came to, without port
  bool is_secure = false;     // it came by TLS
};

// What it is answered.
struct Reply {
  int status = 0;
  std::string content_type;
  absl::string_view contents;  // of a page; good as long as the program runs
  std::string text;            // in place of contents
  std::string etag;
};

// What there is at which address, and who may have it. Threads: any method from any thread.
class Site {
 public:
  // `allowed_hosts`: names besides localhost and the addresses that it listens on by which pages
  // may be asked for.
  Site(std::vector<std::string> allowed_hosts, const std::vector<EmbeddedPage>& pages);

  // Whether the request may become a WebSocket: status 101. Otherwise what it is answered.
  Reply ReplyToSocket(const HttpRequestInfo& request) const;
  // What a request that wants no WebSocket is answered.
  Reply ReplyToPage(const HttpRequestInfo& request) const;

  // Headers of every reply: what a page may load, and that nobody may guess, frame or tell.
  static std::vector<std::pair<std::string, std::string>> SafetyHeaders(
      const HttpRequestInfo& request);

 private:
  struct File {
    std::string content_type;
    absl::string_view contents;
    std::string etag;
  };

  // Whether it asks by a name that is this server's. A page of elsewhere whose name was made to
  // lead here is kept out by that.
  bool IsOurHost(const HttpRequestInfo& request) const;
  static Reply WrongHost(const HttpRequestInfo& request);

  const std::vector<std::string> allowed_hosts_;
  std::map<std::string, File, std::less<>> files_;  // by path
};

}  // namespace procgen::web

#endif  // SERVER_WEB_HTTP_SITE_H_
