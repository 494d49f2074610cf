#ifndef SERVER_RPC_WATCH_WATCH_NODES_REACTOR_H_
#define SERVER_RPC_WATCH_WATCH_NODES_REACTOR_H_

#include <memory>

#include "server/cluster/cluster.h"
#include "server/rpc/auth/call_accounting.h"
#include "server/rpc/watch/latest_stream.h"
#include "server/session/quota/quotas.h"

namespace procgen {

// One stream of WatchNodes: sends the nodes, and again when they have changed.
// Threads: any method from any thread.
class WatchNodesReactor final : public LatestStream {
 public:
  // Begins a stream, which lives until gRPC has done with it, and longer if somebody holds it.
  // `reservation`: of the owner's calls; the stream is one of them while it lasts. `cluster` and
  // `accounting` must outlive it.
  static std::shared_ptr<WatchNodesReactor> Start(Cluster* cluster,
                                                  const CallAccounting* accounting,
                                                  Quotas::Reservation reservation);
  ~WatchNodesReactor() override = default;

 private:
  WatchNodesReactor(Cluster* cluster, const CallAccounting* accounting,
                    Quotas::Reservation reservation);

  void OnRequest(absl::StatusOr<grpc::ByteBuffer> request) override;
  void ReleaseSource() override;

  void SendNodes();

  Cluster* const cluster_;
  const Quotas::Reservation reservation_;
  Subscription subscription_;
};

}  // namespace procgen

#endif  // SERVER_RPC_WATCH_WATCH_NODES_REACTOR_H_
