#ifndef TESTS_CLIENTS_CPP_SERVER_FIXTURE_H_
#define TESTS_CLIENTS_CPP_SERVER_FIXTURE_H_

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "envcore/pool/batch_numbers.h"
#include "envcore/pool/pool.h"
#include "gtest/gtest.h"
#include "procgen_client/servers.h"
#include "server/rpc/server.h"
#include "tests/status_matchers.h"

namespace procgen {

// Options of a pool of maze.
inline PoolOptions MazeOptions(int32_t env_count) {
  PoolOptions options;
  options.games = {"maze"};
  options.env_count = env_count;
  options.environment.rand_seed = 7;
  return options;
}

// A server in this process, and pools on it.
class ServerTest : public testing::Test {
 protected:
  void SetUp() override { Start({}); }

  // Starts a server with these limits in place of the one before.
  void Start(const Limits& limits) {
    ServerOptions options;
    options.address = "127.0.0.1:0";
    options.worker_count = 2;
    options.limits = limits;
    auto server = Server::Start(options);
    ASSERT_THAT(server, IsOk());
    server_ = *std::move(server);
  }

  // A pool on the server at `address`; empty: server_.
  std::unique_ptr<procgen_client::Pool> CreatePool(
      const PoolOptions& options, const procgen_client::RemotePoolOptions& remote = {},
      std::string address = "") const {
    if (address.empty()) {
      address = server_->address();
    }
    const auto servers = procgen_client::Servers::Connect(address);
    EXPECT_THAT(servers, IsOk());
    auto pool = procgen_client::CreatePool(*servers, options, remote);
    EXPECT_TRUE(pool.ok()) << pool.status();
    return *std::move(pool);
  }

  // Memory of a batch with all arrays.
  struct Memory {
    explicit Memory(int32_t env_count)
        : env_count(env_count), observations(static_cast<size_t>(env_count) * kObservationBytes) {}

    Batch batch() {
      Batch batch;
      batch.observations = absl::MakeSpan(observations);
      return numbers.ReplaceEmptyArrays(batch, env_count);
    }

    int32_t env_count;
    BatchNumbers numbers;
    std::vector<uint8_t> observations;
  };

  std::unique_ptr<Server> server_;
};

}  // namespace procgen

#endif  // TESTS_CLIENTS_CPP_SERVER_FIXTURE_H_
