#include "server/rpc/watch/watch_nodes_reactor.h"

#include <utility>

#include "grpcpp/impl/codegen/proto_utils.h"
#include "procgen/v1/cluster.pb.h"
#include "server/wire/convert_node.h"

namespace procgen {

std::shared_ptr<WatchNodesReactor> WatchNodesReactor::Start(Cluster* cluster,
                                                            const CallAccounting* accounting,
                                                            Quotas::Reservation reservation) {
  std::shared_ptr<WatchNodesReactor> reactor(
      new WatchNodesReactor(cluster, accounting, std::move(reservation)));
  reactor->Begin(reactor);
  reactor->subscription_ = cluster->Subscribe([watch = reactor.get()] { watch->SendNodes(); });
  reactor->SendNodes();
  return reactor;
}

WatchNodesReactor::WatchNodesReactor(Cluster* cluster, const CallAccounting* accounting,
                                     Quotas::Reservation reservation)
    : LatestStream(accounting, "ClusterService/WatchNodes"),
      cluster_(cluster),
      reservation_(std::move(reservation)) {}

void WatchNodesReactor::ReleaseSource() { subscription_ = Subscription(); }

void WatchNodesReactor::SendNodes() {
  Send([this] {
    grpc::ByteBuffer response;
    bool own_buffer = false;
    grpc::SerializationTraits<v1::WatchNodesResponse>::Serialize(
        NodesMessageOf<v1::WatchNodesResponse>(*cluster_), &response, &own_buffer);
    return response;
  });
}

}  // namespace procgen
