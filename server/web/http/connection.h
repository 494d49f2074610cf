#ifndef SERVER_WEB_HTTP_CONNECTION_H_
#define SERVER_WEB_HTTP_CONNECTION_H_

#include <memory>

#include "boost/asio/ip/tcp.hpp"
#include "boost/asio/ssl/context.hpp"
#include "server/web/http/bridge_socket.h"
#include "server/web/http/open_sockets.h"
#include "server/web/http/site.h"

namespace procgen::web {

// Shared by all connections.
struct ConnectionContext {
  const Site* site = nullptr;
  BridgeContext* bridge = nullptr;
  OpenSockets* sockets = nullptr;
};

// Serves HTTP on a connection, on its strand, until it ends or becomes a WebSocket. A null `tls`
// means plain text. `context` must outlive the I/O context.
void StartConnection(boost::asio::ip::tcp::socket socket,
                     const std::shared_ptr<boost::asio::ssl::context>& tls,
                     const ConnectionContext& context);

}  // namespace procgen::web

#endif  // SERVER_WEB_HTTP_CONNECTION_H_
