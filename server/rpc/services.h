#ifndef SERVER_RPC_SERVICES_H_
#define SERVER_RPC_SERVICES_H_

#include <initializer_list>

#include "grpcpp/server_builder.h"
#include "server/cluster/cluster.h"
#include "server/rpc/caller.h"
#include "server/rpc/catalog_service.h"
#include "server/rpc/clone_sources.h"
#include "server/rpc/cluster_service.h"
#include "server/rpc/pool_service.h"
#include "server/rpc/render_service.h"
#include "server/rpc/state_service.h"
#include "server/rpc/step_service.h"
#include "server/session/sessions.h"

namespace procgen {

// All services of the contract. Threads: as those of its members; it must outlive the gRPC server.
class Services {
 public:
  // `sessions`, `cluster` and `callers` must outlive this.
  Services(Sessions* sessions, Cluster* cluster, const Callers* callers,
           const CloneSources& clone_sources)
      : catalog_(sessions, callers),
        cluster_(cluster, callers),
        pool_(sessions, callers),
        step_(sessions, callers),
        state_(sessions, callers, clone_sources),
        render_(sessions, callers) {}

  void RegisterWith(grpc::ServerBuilder* builder) {
    for (grpc::Service* service : std::initializer_list<grpc::Service*>{
             &catalog_, &cluster_, &pool_, &step_, &state_, &render_}) {
      builder->RegisterService(service);
    }
  }

  // Ends the streams that would go on for as long as the server does.
  void EndWatches() { cluster_.EndWatches(); }

 private:
  CatalogServiceImpl catalog_;
  ClusterServiceImpl cluster_;
  PoolServiceImpl pool_;
  StepServiceImpl step_;
  StateServiceImpl state_;
  RenderServiceImpl render_;
};

}  // namespace procgen

#endif  // SERVER_RPC_SERVICES_H_
