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
#include "tests/service/pool_stream.h"
#include "tests/status_matchers.h"

namespace procgen {

// A pool of `env_count` environments of maze with easy levels and rand_seed 7.
v1::PoolSpec MazeSpec(int32_t env_count);

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

  // Starts another server.
  static std::unique_ptr<Server> StartServer(int32_t worker_count,
                                             const Limits& limits = TestLimits());
  // Creates a pool. Null: an error, which has failed the test.
  std::unique_ptr<PoolStream> StartPool(const v1::PoolSpec& spec, const std::string& pool_id = "");
  // How the attempt to create a pool ends. The pool is freed.
  absl::Status StartError(const v1::PoolSpec& spec, const std::string& pool_id = "");

  std::unique_ptr<Server> server_;
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<procgen_client::Client> client_;
  bool server_is_alive_ = true;  // set to false by tests that stop the server

 private:
  std::unique_ptr<PoolStream> control_learner_;
};

}  // namespace procgen

#endif  // TESTS_SERVICE_SERVICE_FIXTURE_H_
