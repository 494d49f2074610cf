#ifndef TESTS_SERVICE_SERVICE_FIXTURE_H_
#define TESTS_SERVICE_SERVICE_FIXTURE_H_

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "grpcpp/channel.h"
#include "gtest/gtest.h"
#include "procgen_client/client.h"
#include "server/rpc/server.h"
#include "tests/status_matchers.h"

namespace procgen {

// A pool of `env_count` environments of maze with easy levels and rand_seed 7.
v1::PoolSpec MazeSpec(int32_t env_count);

// Requests of a stream, without sequence numbers.
v1::StepPoolRequest StepRequest(const std::vector<int32_t>& actions);
v1::StepPoolRequest SliceStepRequest(int32_t first, int32_t count, int32_t action);

// A source and target of CloneStates.
v1::ClonePair Pair(int32_t source_environment, int32_t target_environment);

// A server in this process on its own port, and a client. A control learner steps another pool,
// which must still work after every test.
class ServiceTest : public testing::Test {
 protected:
  // Small limits, so that tests can exceed them. The control learner uses one pool and two
  // environments.
  static Limits TestLimits();

  void SetUp() override;
  // Checks that the server and the control learner's pool still work.
  void TearDown() override;

  // Starts another server with the same limits.
  static std::unique_ptr<Server> StartServer(int32_t worker_count);
  // Opens a separate connection that accepts responses of this size.
  std::unique_ptr<procgen_client::Client> Connect(int32_t response_bytes_max = 4 << 20);
  // Creates a pool of `spec` and returns its name.
  std::string CreatePool(const v1::PoolSpec& spec);
  // Creates a pool of `spec` and attaches to it.
  std::unique_ptr<procgen_client::StepStream> CreateAndAttach(
      const v1::PoolSpec& spec, const procgen_client::StreamOptions& options = {});
  // Executes the request and returns its status.
  static absl::Status CallStatus(procgen_client::StepStream* stream, v1::StepPoolRequest request);

  std::unique_ptr<Server> server_;
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<procgen_client::Client> client_;
  bool server_is_alive_ = true;  // set to false by tests that stop the server

 private:
  std::unique_ptr<procgen_client::StepStream> control_learner_;
};

}  // namespace procgen

#endif  // TESTS_SERVICE_SERVICE_FIXTURE_H_
