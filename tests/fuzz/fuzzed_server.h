#ifndef TESTS_FUZZ_FUZZED_SERVER_H_
#define TESTS_FUZZ_FUZZED_SERVER_H_

#include <memory>

#include "absl/status/status.h"
#include "grpcpp/grpcpp.h"
#include "server/cluster/cluster.h"
#include "server/net/connections.h"
#include "server/rpc/auth/call_accounting.h"
#include "server/rpc/services/services.h"
#include "server/session/pool_supervisor.h"
#include "tests/fuzz/pieces.h"

namespace procgen {

// The services of a server with small limits, called by TCP. For fuzz targets: one for the whole
// run.
class FuzzedServer {
 public:
  FuzzedServer();

  const std::shared_ptr<grpc::Channel>& channel() const { return channel_; }

  // Makes the pools that inputs begin with, in place of all that there are: "pools/a" (two
  // environments of maze), and "pools/b" (three of coinrun, which must be reset where an episode
  // ends, and whose observations are encoded).
  void ResetPools();
  // Nobody's stream is attached to a pool. Waits for those that are about to end.
  void RequireNoStreams();

 private:
  Metrics metrics_{"fuzzed"};
  PoolSupervisor supervisor_;
  Connections connections_;
  const CallAccounting accounting_;
  const std::unique_ptr<Cluster> cluster_ = Cluster::Alone("fuzzed");
  Services services_;
  std::unique_ptr<grpc::Server> server_;
  std::shared_ptr<grpc::Channel> channel_;
};

// The one of this process; never destroyed.
FuzzedServer& TheFuzzedServer();

// Requires that an error is one that the protocol documents for invalid input, with a valid
// message.
void RequirePromised(const absl::Status& status);

}  // namespace procgen

#endif  // TESTS_FUZZ_FUZZED_SERVER_H_
