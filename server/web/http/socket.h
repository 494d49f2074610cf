#ifndef SERVER_WEB_HTTP_SOCKET_H_
#define SERVER_WEB_HTTP_SOCKET_H_

#include "boost/beast/http/empty_body.hpp"
#include "boost/beast/http/message.hpp"
#include "server/concurrency/thread_group.h"
#include "server/web/http/byte_stream.h"
#include "server/web/http/open_sockets.h"
#include "server/web/session/page_session.h"

namespace procgen::web {

using UpgradeRequest = boost::beast::http::request<boost::beast::http::empty_body>;

// Shared by the sockets of pages.
struct PageContext {
  const PageSessionContext* session = nullptr;
  ThreadGroup* threads = nullptr;  // of the sessions
};

// Upgrades a connection to a WebSocket and runs its page session on a new thread. `context` and
// `sockets` must outlive the socket.
void OpenPageSocket(ByteStream stream, const UpgradeRequest& request, const PageContext& context,
                    OpenSockets* sockets);

}  // namespace procgen::web

#endif  // SERVER_WEB_HTTP_SOCKET_H_
