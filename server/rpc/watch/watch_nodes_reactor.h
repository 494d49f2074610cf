#ifndef SERVER_RPC_WATCH_WATCH_NODES_REACTOR_H_
#define SERVER_RPC_WATCH_WATCH_NODES_REACTOR_H_

#include <memory>

#include "server/cluster/cluster.h"
#include "server/pool/quota/quotas.h"
#include "server/rpc/auth/call_accounting.h"
#include "server/rpc/watch/latest_stream.h"

namespace procgen {

// One stream of WatchNodes: sends all nodes at the start and after each change.
// Threads: any method from any thread.
class WatchNodesReactor final : public LatestStream {
 public:
  // Starts a stream, which lives at least until OnDone. `reservation`: of the owner's calls, held
  // until the stream ends. `cluster` and `accounting` must outlive the stream.
  static std::shared_ptr<WatchNodesReactor> Start(Cluster* cluster,
                                                  const CallAccounting* accounting,
                                                  Quotas::Reservation reservation);
  ~WatchNodesReactor() override = default;

 private:
  WatchNodesReactor(Cluster* cluster, const CallAccounting* accounting,
                    Quotas::Reservation reservation);

  void ReleaseSource() override;

  void SendNodes();

  Cluster* const cluster_;
  const Quotas::Reservation reservation_;
  Subscription subscription_;
};

}  // namespace procgen

#endif  // SERVER_RPC_WATCH_WATCH_NODES_REACTOR_H_
