#ifndef SERVER_RPC_SERVER_H_
#define SERVER_RPC_SERVER_H_

#include <cstdint>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "envcore/pool/shared_art.h"
#include "server/cluster/cluster.h"
#include "server/metrics/metrics.h"
#include "server/net/tls_files.h"
#include "server/pool/quota/limits.h"
#include "server/rpc/auth/token_file.h"
#include "server/rpc/bridge/generic_call.h"

namespace procgen {

struct ServerOptions {
  // Address to listen on: "host:port" (port 0: any free port) or "unix:path".
  std::string address = "127.0.0.1:50051";
  // Address where clients and nodes reach the server; port 0: the bound port. Empty: `address`.
  std::string advertised_address;
  std::shared_ptr<Cluster> cluster;  // null: a server without a cluster
  int32_t worker_count = 1;          // threads that step environments, >= 1
  Limits limits;
  std::shared_ptr<const SharedArt> art;  // of all pools; null: the built-in art
  std::shared_ptr<TlsFiles> tls;         // null: plain text
  std::shared_ptr<TokenFile> tokens;     // null: calls need no token
  // Idle time after which the server sends a keepalive ping, and the time without a reply after
  // which it closes the connection.
  absl::Duration keepalive_time = absl::Seconds(30);
  absl::Duration keepalive_timeout = absl::Seconds(10);
};

// A Procgen server: pools and the gRPC services that expose them on a port.
// Threads: any method from any thread.
class Server {
 public:
  // Starts to listen and serve. Errors: UNAVAILABLE it cannot listen on the address;
  // RESOURCE_EXHAUSTED its threads cannot be started.
  static absl::StatusOr<std::unique_ptr<Server>> Start(const ServerOptions& options);
  // Stops immediately and cancels all calls.
  virtual ~Server() = default;

  // The listening address with the bound port, in the form that clients connect to.
  virtual const std::string& address() const = 0;
  // The server's metrics, valid while the server exists.
  virtual const Metrics& metrics() const = 0;

  // Returns a stub by which pages call this server, with the same authentication as any other
  // client. It buffers little, so that a slow page delays its streams. Valid while the server
  // exists.
  virtual std::unique_ptr<GenericStub> MakeStub() const = 0;

  // Reports the drain to the cluster and NOT_SERVING to health checks, rejects new pools, and ends
  // each stream after its current request. Returns immediately.
  virtual void BeginDrain() = 0;
  // Calls BeginDrain, waits at most `timeout` until no call is in progress, cancels the rest, and
  // stops. Blocks.
  virtual void Stop(absl::Duration timeout) = 0;
};

}  // namespace procgen

#endif  // SERVER_RPC_SERVER_H_
