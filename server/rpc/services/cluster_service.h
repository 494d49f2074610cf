#ifndef SERVER_RPC_SERVICES_CLUSTER_SERVICE_H_
#define SERVER_RPC_SERVICES_CLUSTER_SERVICE_H_

#include "procgen/v1/cluster.grpc.pb.h"
#include "server/cluster/cluster.h"
#include "server/rpc/auth/call_accounting.h"

namespace procgen {

// ClusterService: lists the nodes of the cluster.
class ClusterServiceImpl final : public v1::ClusterService::CallbackService {
 public:
  // `cluster` and `accounting` must outlive this.
  ClusterServiceImpl(const Cluster* cluster, const CallAccounting* accounting)
      : cluster_(cluster), accounting_(accounting) {}

  grpc::ServerUnaryReactor* ListNodes(grpc::CallbackServerContext* context,
                                      const v1::ListNodesRequest* request,
                                      v1::ListNodesResponse* response) override;

 private:
  const Cluster* const cluster_;
  const CallAccounting* const accounting_;
};

}  // namespace procgen

#endif  // SERVER_RPC_SERVICES_CLUSTER_SERVICE_H_
