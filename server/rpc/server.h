#ifndef SERVER_RPC_SERVER_H_
#define SERVER_RPC_SERVER_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "envcore/pool/shared_art.h"
#include "grpcpp/channel.h"
#include "procgen/v1/pools.pb.h"
#include "server/cluster/cluster.h"
#include "server/metrics/metrics.h"
#include "server/net/tls_files.h"
#include "server/rpc/auth/token_file.h"
#include "server/rpc/services/clone_source_allowlist.h"
#include "server/session/backend/pool_backend.h"
#include "server/session/quota/limits.h"
#include "server/shared_memory/shared_folder.h"

namespace procgen {

struct ServerOptions {
  // Where to listen: "host:port", port 0 for any that is free, or "unix:path".
  std::string address = "127.0.0.1:50051";
  // Where clients reach it, as the cluster is told; port 0: the one that was bound. Empty: as
  // `address`.
  std::string advertised_address;
  std::shared_ptr<Cluster> cluster;  // that it is a node of; null: it is alone
  int32_t worker_count = 1;          // threads that step environments, >= 1
  Limits limits;
  std::shared_ptr<const SharedArt> art;  // all pools draw with it; null: the built-in art
  std::shared_ptr<TlsFiles> tls;         // null: plain text
  std::shared_ptr<TokenFile> tokens;     // null: nobody is asked for one
  // Where pools share memory with learners on this machine; null: they share none.
  std::shared_ptr<const SharedFolder> shared_folder;
  CloneSourceAllowlist clone_source_allowlist;  // whom CloneStates may be asked to connect to
  // Makes where pools are made, which counts what it does in `metrics`; null: in this process.
  std::function<std::unique_ptr<PoolBackendFactory>(Metrics* metrics)> make_backend_factory;
  // A connection on which nothing arrived for `keepalive_time` is asked for a sign of life, and
  // ended if there is none within `keepalive_timeout`.
  absl::Duration keepalive_time = absl::Seconds(30);
  absl::Duration keepalive_timeout = absl::Seconds(10);
};

// The whole server in one object: services on a port, pools behind them.
// Threads: any method from any thread.
class Server {
 public:
  // Listens and serves. Errors: UNAVAILABLE the address cannot be listened on; RESOURCE_EXHAUSTED
  // its threads cannot be started.
  static absl::StatusOr<std::unique_ptr<Server>> Start(const ServerOptions& options);
  // Stops at once: what runs is cancelled.
  virtual ~Server() = default;

  // Where it listens, with the port that was bound, as clients connect to it.
  virtual const std::string& address() const = 0;
  // What it has counted; to be read no longer than there is a server.
  virtual const Metrics& metrics() const = 0;

  // A way to its services within the process, for which callers are asked who they are as for any
  // other; to be used no longer than there is a server.
  virtual std::shared_ptr<grpc::Channel> MakeChannel() const = 0;
  // All pools, whoever owns them: what is told of them is for their owners alone.
  virtual std::vector<v1::Pool> ListAllPools() const = 0;

  // Tells the cluster that it drains and the health service NOT_SERVING, makes no more pools and
  // ends all streams after the request that each is carrying out. Returns at once.
  virtual void BeginDrain() = 0;
  // BeginDrain; then waits, `timeout` at most, until no call is under way and the pools whose
  // streams it ended are deleted (their learners may want to save states), and stops; what is left
  // is cancelled. Blocks.
  virtual void Stop(absl::Duration timeout) = 0;
};

}  // namespace procgen

#endif  // SERVER_RPC_SERVER_H_
