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

// A pair of CloneStates.
v1::ClonePair Pair(int32_t source_environment, int32_t target_environment);

// A real server in this process, on a port of its own, and a client of it. Beside the test's own
// pools there is a witness: a learner whose pool must go on, whatever the test does to the server.
class ServiceTest : public testing::Test {
 protected:
  // Small, so that tests reach them; the witness has one pool and two environments.
  static Limits TestLimits();

  void SetUp() override;
  // Checks that the server and the witness' pool go on.
  void TearDown() override;

  // Another server, with the same limits.
  static std::unique_ptr<Server> StartServer(int32_t worker_count);
  // A client of its own connection that takes responses of this size.
  std::unique_ptr<procgen_client::Client> Connect(int32_t response_bytes_max = 4 << 20);
  // The name of a pool made of `spec`.
  std::string CreatePool(const v1::PoolSpec& spec);
  // A stream on a pool made of `spec`.
  std::unique_ptr<procgen_client::StepStream> CreateAndAttach(
      const v1::PoolSpec& spec, const procgen_client::StreamOptions& options = {});
  // Calls and returns how the stream ended.
  static absl::Status CallStatus(procgen_client::StepStream* stream, v1::StepPoolRequest request);

  std::unique_ptr<Server> server_;
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<procgen_client::Client> client_;
  bool server_goes_on_ = true;  // false: the test has stopped it

 private:
  std::unique_ptr<procgen_client::StepStream> witness_;
};

}  // namespace procgen

#endif  // TESTS_SERVICE_SERVICE_FIXTURE_H_
