#include "procgen_client/client.h"

#include <numeric>
#include <string>
#include <vector>

#include "absl/time/clock.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/clients/cpp/server_fixture.h"

namespace procgen {
namespace {

using testing::Each;
using testing::HasSubstr;
using testing::SizeIs;

class ClientTest : public ServerTest {};

TEST_F(ClientTest, ConnectWithoutListenerFailsSoonAndSaysSo) {
  const absl::Time begin = absl::Now();
  EXPECT_THAT(procgen_client::Client::Connect("127.0.0.1:1"),
              StatusIs(absl::StatusCode::kUnavailable,
                       "no server listens at 127.0.0.1:1: Connection refused"));
  EXPECT_THAT(procgen_client::Client::Connect("unix:/no/such/socket"),
              StatusIs(absl::StatusCode::kUnavailable,
                       "no server listens at unix:/no/such/socket: No such file or directory"));
  EXPECT_LT(absl::Now() - begin, absl::Seconds(8)) << "of 2 x 10 s that a silent server has";
}

TEST_F(ClientTest, GivenTimeoutAlsoHoldsWhileNothingListens) {
  procgen_client::ConnectOptions options;
  options.timeout = absl::Milliseconds(2200);
  const absl::Time begin = absl::Now();
  EXPECT_THAT(procgen_client::Client::Connect("127.0.0.1:1", options),
              StatusIs(absl::StatusCode::kUnavailable, HasSubstr("Connection refused")));
  EXPECT_GE(absl::Now() - begin, *options.timeout) << "the server may still be starting";
}

TEST_F(ClientTest, AddressWithoutPortIsRejectedAtOnce) {
  for (const char* address : {"localhost", "", "http://localhost:50051", "::1:50051",
                              "localhost:", "localhost:0", "localhost:65536", "localhost:http"}) {
    EXPECT_THAT(procgen_client::Client::Connect(address),
                StatusIs(absl::StatusCode::kInvalidArgument,
                         HasSubstr("it is host:port (localhost:50051, [::1]:50051)")))
        << address;
  }
}

TEST_F(ClientTest, OneServerOfAListMustAnswer) {
  procgen_client::ConnectOptions options;
  options.timeout = absl::Milliseconds(300);
  EXPECT_THAT(procgen_client::Servers::Connect("127.0.0.1:1,127.0.0.1:2", options),
              StatusIs(absl::StatusCode::kUnavailable, testing::_));
  const auto servers =
      procgen_client::Servers::Connect("127.0.0.1:1," + server_->address(), options);
  ASSERT_THAT(servers, IsOk());
  EXPECT_THAT((*servers)->All(), SizeIs(2));
  EXPECT_THAT((*servers)->first()->GetLoad(), IsOk());
}

TEST_F(ClientTest, PoolLivesAsLongAsItsObject) {
  const auto client = procgen_client::Client::Connect(server_->address());
  ASSERT_THAT(client, IsOk());
  procgen_client::RemotePoolOptions options;
  options.pool_id = "mine";
  const auto pool = CreatePool(MazeOptions(2), options);
  EXPECT_EQ(pool->name(), "pools/mine");
  ASSERT_THAT(*(*client)->ListPools(), SizeIs(1));
  EXPECT_EQ((*client)->GetPool("pools/mine")->spec().env_count(), 2);
  EXPECT_THAT(CreatePool(MazeOptions(1))->Step({.count = 1, .steps = false}, {}, {}), IsOk());
  EXPECT_THAT(*(*client)->ListPools(), SizeIs(1)) << "the other one has ended";
}

TEST_F(ClientTest, LargeBatchesAndStatesAreSplitIntoRequests) {
  constexpr int32_t kEnvCount = 150;
  const std::vector<int32_t> actions(kEnvCount, 3);
  const std::vector<int32_t> ends(kEnvCount, -1);
  std::vector<int32_t> environments(kEnvCount);
  std::iota(environments.begin(), environments.end(), 0);
  std::vector<Memory> results;
  for (const bool is_small : {false, true}) {
    Limits limits;
    if (is_small) {
      limits.request_bytes_max = 65536;
      limits.response_bytes_max = 1 << 20;
    }
    Start(limits);
    const auto pool = CreatePool(MazeOptions(kEnvCount));
    const auto states = pool->SaveStates(environments);
    ASSERT_TRUE(states.ok()) << states.status();
    std::vector<StateToRestore> restored;
    size_t bytes = 0;
    for (const int32_t environment : environments) {
      const std::string& snapshot = (*states)[static_cast<size_t>(environment)];
      restored.push_back({.environment = environment, .snapshot = snapshot});
      bytes += snapshot.size();
    }
    ASSERT_GT(bytes, 2U * 65536);
    Memory& memory = results.emplace_back(kEnvCount);
    ASSERT_THAT(pool->Step({.count = kEnvCount, .actions = ends}, {}, memory.batch()), IsOk());
    ASSERT_THAT(pool->RestoreStates(restored), IsOk());
    ASSERT_THAT(pool->Step({.count = kEnvCount, .actions = actions}, {}, memory.batch()), IsOk());
    EXPECT_THAT(memory.numbers.episode_lengths, Each(1)) << "of the first episode";
  }
  EXPECT_EQ(results[0].numbers, results[1].numbers);
  EXPECT_EQ(results[0].observations, results[1].observations);
}

}  // namespace
}  // namespace procgen
