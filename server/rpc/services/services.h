#ifndef SERVER_RPC_SERVICES_SERVICES_H_
#define SERVER_RPC_SERVICES_SERVICES_H_

#include <set>
#include <string>
#include <vector>

#include "grpcpp/server_builder.h"
#include "server/cluster/cluster.h"
#include "server/rpc/auth/call_accounting.h"
#include "server/rpc/call/byte_service.h"
#include "server/rpc/call/unknown_methods.h"
#include "server/rpc/dm_env_rpc/dm_env_rpc_service.h"
#include "server/rpc/services/catalog_service.h"
#include "server/rpc/services/clone_source_allowlist.h"
#include "server/rpc/services/cluster_service.h"
#include "server/rpc/services/health_service.h"
#include "server/rpc/services/pool_service.h"
#include "server/rpc/services/reflection_service.h"
#include "server/rpc/services/render_service.h"
#include "server/rpc/services/state_service.h"
#include "server/rpc/step/step_service.h"
#include "server/session/pool_supervisor.h"
#include "server/shared_memory/pipe_listener.h"

namespace procgen {

// All services: those of the API, dm_env_rpc, and gRPC's health and reflection. Must outlive the
// gRPC server.
// Threads: any method from any thread.
class Services {
 public:
  // `pipe_listener`: for pools that share memory; null: pipes are not offered. The pointers must
  // outlive this.
  Services(PoolSupervisor* supervisor, Cluster* cluster, const CallAccounting* accounting,
           PipeListener* pipe_listener, const CloneSourceAllowlist& clone_source_allowlist)
      : catalog_(supervisor, accounting),
        cluster_(cluster, accounting),
        pool_(supervisor, accounting),
        step_(supervisor, accounting, pipe_listener),
        state_(supervisor, accounting, clone_source_allowlist),
        render_(supervisor, accounting),
        dm_env_rpc_(supervisor, accounting),
        pool_services_({&catalog_, &cluster_, &pool_, &step_, &state_, &render_, &dm_env_rpc_}),
        health_(accounting, NamesOf(pool_services_)),
        reflection_(accounting, NamesOf(pool_services_)) {}

  void RegisterWith(grpc::ServerBuilder* builder) {
    for (ByteService* service : pool_services_) {
      builder->RegisterService(service);
    }
    builder->RegisterService(&health_);
    builder->RegisterService(&reflection_);
    builder->RegisterCallbackGenericService(&unknown_methods_);
  }

  // Sets the status that the health service reports for all services.
  void SetServing(bool is_serving) { health_.SetServing(is_serving); }

  // Ends the streams that otherwise last as long as the server.
  void EndWatches() {
    cluster_.EndWatches();
    health_.EndWatches();
  }

  // Ends the streams that PoolSupervisor::Drain does not end.
  void Drain() { dm_env_rpc_.Drain(); }

 private:
  static std::set<std::string> NamesOf(const std::vector<ByteService*>& services) {
    std::set<std::string> names;
    for (const ByteService* service : services) {
      names.insert(service->service_name());
    }
    return names;
  }

  CatalogServiceImpl catalog_;
  ClusterServiceImpl cluster_;
  PoolServiceImpl pool_;
  StepServiceImpl step_;
  StateServiceImpl state_;
  RenderServiceImpl render_;
  DmEnvRpcServiceImpl dm_env_rpc_;
  const std::vector<ByteService*> pool_services_;  // the services above
  HealthServiceImpl health_;
  ReflectionServiceImpl reflection_;
  UnknownMethods unknown_methods_;
};

}  // namespace procgen

#endif  // SERVER_RPC_SERVICES_SERVICES_H_
