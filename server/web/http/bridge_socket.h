#ifndef SERVER_WEB_HTTP_BRIDGE_SOCKET_H_
#define SERVER_WEB_HTTP_BRIDGE_SOCKET_H_

#include <atomic>
#include <cstdint>

#include "boost/beast/http/empty_body.hpp"
#include "boost/beast/http/message.hpp"
#include "server/rpc/bridge/generic_call.h"
#include "server/web/http/byte_stream.h"
#include "server/web/http/open_sockets.h"

namespace procgen::web {

using UpgradeRequest = boost::beast::http::request<boost::beast::http::empty_body>;

// Shared by the sockets of all pages.
struct BridgeContext {
  GenericStub* stub = nullptr;
  int64_t message_bytes_max = 0;     // size of a message of a page
  int32_t viewers_max = 0;           // pages at a time
  std::atomic<int32_t> viewers = 0;  // pages now
};

// Upgrades a connection to a WebSocket that speaks proto/procgen/web/v1/bridge.proto. `context` and
// `sockets` must outlive the socket.
void OpenBridgeSocket(ByteStream stream, const UpgradeRequest& request, BridgeContext* context,
                      OpenSockets* sockets);

}  // namespace procgen::web

#endif  // SERVER_WEB_HTTP_BRIDGE_SOCKET_H_
