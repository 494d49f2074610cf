#ifndef SERVER_RPC_SERVICES_CLUSTER_SERVICE_H_
#define SERVER_RPC_SERVICES_CLUSTER_SERVICE_H_

#include <memory>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "procgen/v1/cluster.grpc.pb.h"
#include "server/cluster/cluster.h"
#include "server/rpc/auth/call_accounting.h"
#include "server/rpc/watch/watch_nodes_reactor.h"

namespace procgen {

// ClusterService: lists and watches the nodes of the cluster.
class ClusterServiceImpl final
    : public v1::ClusterService::WithCallbackMethod_ListNodes<
          v1::ClusterService::WithRawCallbackMethod_WatchNodes<v1::ClusterService::Service>> {
 public:
  // `cluster` and `accounting` must outlive this.
  ClusterServiceImpl(Cluster* cluster, const CallAccounting* accounting);

  grpc::ServerUnaryReactor* ListNodes(grpc::CallbackServerContext* context,
                                      const v1::ListNodesRequest* request,
                                      v1::ListNodesResponse* response) override;
  grpc::ServerWriteReactor<grpc::ByteBuffer>* WatchNodes(grpc::CallbackServerContext* context,
                                                         const grpc::ByteBuffer* request) override;

  // Ends all current and future streams of WatchNodes. Threads: any.
  void EndWatches() ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  Cluster* const cluster_;
  const CallAccounting* const accounting_;
  absl::Mutex mutex_;
  std::vector<std::weak_ptr<WatchNodesReactor>> watches_ ABSL_GUARDED_BY(mutex_);
  bool ends_watches_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace procgen

#endif  // SERVER_RPC_SERVICES_CLUSTER_SERVICE_H_
