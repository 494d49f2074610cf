#ifndef TESTS_FUZZ_FUZZED_SERVER_H_
#define TESTS_FUZZ_FUZZED_SERVER_H_

#include <memory>

#include "absl/status/status.h"
#include "grpcpp/grpcpp.h"
#include "server/cluster/cluster.h"
#include "server/rpc/auth/call_accounting.h"
#include "server/rpc/services/services.h"
#include "server/session/pool_supervisor.h"
#include "tests/fuzz/pieces.h"

namespace procgen {

// The services of a server with small limits, called over TCP. Fuzz targets use one instance for
// the whole run.
class FuzzedServer {
 public:
  FuzzedServer();

  const std::shared_ptr<grpc::Channel>& channel() const { return channel_; }

  // Replaces all pools by the initial ones: "pools/a" (two environments of maze) and "pools/b"
  // (three of coinrun without automatic resets, with encoded observations).
  void ResetPools();
  // Aborts if a stream is attached to a pool. First waits for streams that are ending.
  void RequireNoStreams();

 private:
  Metrics metrics_{"fuzzed"};
  PoolSupervisor supervisor_;
  const CallAccounting accounting_;
  const std::unique_ptr<Cluster> cluster_ = Cluster::Alone("fuzzed");
  Services services_;
  std::unique_ptr<grpc::Server> server_;
  std::shared_ptr<grpc::Channel> channel_;
};

// The instance of this process; never destroyed.
FuzzedServer& TheFuzzedServer();

// Aborts unless the protocol documents the error for invalid input and its message is valid.
void RequirePromised(const absl::Status& status);

}  // namespace procgen

#endif  // TESTS_FUZZ_FUZZED_SERVER_H_
