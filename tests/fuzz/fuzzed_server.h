#ifndef TESTS_FUZZ_FUZZED_SERVER_H_
#define TESTS_FUZZ_FUZZED_SERVER_H_

#include <memory>
#include <string>

#include "absl/status/status.h"
#include "grpcpp/grpcpp.h"
#include "procgen/v1/pool_service.grpc.pb.h"
#include "procgen/v1/run.pb.h"
#include "server/cluster/cluster.h"
#include "server/metrics/metrics.h"
#include "server/pool/pool_supervisor.h"
#include "server/rpc/auth/call_accounting.h"
#include "server/rpc/services/catalog_service.h"
#include "server/rpc/services/cluster_service.h"
#include "server/rpc/services/pool_service.h"
#include "tests/fuzz/pieces.h"

namespace procgen {

inline constexpr char kRunPool[] = "/procgen.v1.PoolService/RunPool";

// The services of a server with small limits, called over TCP. Fuzz targets use one instance for
// the whole run.
class FuzzedServer {
 public:
  FuzzedServer();

  const std::shared_ptr<grpc::Channel>& channel() const { return channel_; }

  // Aborts unless the server has `count` pools. First waits for streams that are ending.
  void RequirePoolCount(int32_t count);

 private:
  Metrics metrics_{"fuzzed"};
  PoolSupervisor supervisor_;
  const CallAccounting accounting_;
  const std::unique_ptr<Cluster> cluster_ = Cluster::Alone("fuzzed");
  CatalogServiceImpl catalog_service_;
  ClusterServiceImpl cluster_service_;
  PoolServiceImpl pool_service_;
  std::unique_ptr<grpc::Server> server_;
  std::shared_ptr<grpc::Channel> channel_;
};

// The instance of this process; never destroyed.
FuzzedServer& TheFuzzedServer();

// A pool "pools/a" of two mazes, which a learner steps while others look at it.
class LivePool {
 public:
  LivePool();

  // Steps both environments once. Aborts if that fails.
  void Step();

 private:
  v1::RunPoolResponse Answer(const v1::RunPoolRequest& request);

  const std::unique_ptr<v1::PoolService::Stub> stub_;
  grpc::ClientContext context_;
  const std::unique_ptr<grpc::ClientReaderWriter<v1::RunPoolRequest, v1::RunPoolResponse>> stream_;
};

// The instance of this process; never destroyed.
LivePool& TheLivePool();

// Aborts unless the protocol documents the error for invalid input and its message is valid.
void RequirePromised(const absl::Status& status);

}  // namespace procgen

#endif  // TESTS_FUZZ_FUZZED_SERVER_H_
