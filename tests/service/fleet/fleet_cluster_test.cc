// A fleet as in production: nodes and a fleet server, each a process, in a real cluster. The
// learner's responses equal those of one server.

#include <csignal>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "envcore/pool/pool.h"
#include "gtest/gtest.h"
#include "tests/service/fleet/test_fleet.h"
#include "tests/service/scripted_learner.h"
#include "tests/service/server_process.h"
#include "tests/service/states/episode_replay.h"
#include "tests/status_matchers.h"
#include "tests/temporary_folder.h"

namespace procgen {
namespace {

LearnerScript Script(int request_count = 1500) {
  LearnerScript script;
  script.request_count = request_count;
  for (const char* game : {"coinrun", "starpilot", "maze"}) {
    script.spec.add_games(game);
  }
  script.spec.set_env_count(24);
  script.spec.mutable_options()->set_rand_seed(3);
  return script;
}

LearnerTrace SingleServerTrace(const LearnerScript& script) {
  ServerProcess single({"--address=127.0.0.1:0", "--log_level=error"});
  const auto client = procgen_client::Client::Connect(single.Address()).value();
  const auto trace = PlayScript(script, client.get(), [](int) {});
  EXPECT_THAT(trace, IsOk());
  return trace.value();
}

void ExpectSameTrace(const LearnerScript& script, const TestFleet& fleet,
                     const std::function<void(int)>& faults) {
  const LearnerTrace expected = SingleServerTrace(script);
  const auto actual = PlayScript(script, fleet.Connect().get(), faults);
  ASSERT_THAT(actual, IsOk());
  EXPECT_EQ(FirstDifference(expected, *actual), -1);
}

TEST(FleetClusterTest, LearnerIsUnaffectedByNodesThatDieStopDrainAndJoin) {
  TestFleet fleet;
  fleet.StartNode("a");
  fleet.StartNode("b");
  fleet.StartNode("c");
  fleet.StartFleet(3);
  std::unique_ptr<ServerProcess> drained;
  ExpectSameTrace(Script(), fleet, [&](int index) {
    if (index == 200) {
      fleet.KillNode("a");
    }
    if (index == 500) {
      fleet.node("b").Signal(SIGSTOP);
    }
    if (index == 600) {
      fleet.node("b").Signal(SIGCONT);
      fleet.StartNode("d");
    }
    if (index == 1000) {
      drained = fleet.TakeNode("c");
      drained->Signal(SIGTERM);
    }
  });
  const absl::Time begin = absl::Now();
  EXPECT_EQ(drained->Wait(), 0);
  EXPECT_LT(absl::Now() - begin, absl::Seconds(15)) << "its shards were not taken away";
}

TEST(FleetClusterTest, AnIdlePoolLeavesADrainingNode) {
  TestFleet fleet;
  fleet.StartNode("a");
  fleet.StartFleet(1);
  const auto client = fleet.Connect();
  ASSERT_THAT(client->CreatePool(Script().spec), IsOk());
  fleet.StartNode("b");
  const auto drained = fleet.TakeNode("a");
  drained->Signal(SIGTERM);
  const absl::Time begin = absl::Now();
  EXPECT_EQ(drained->Wait(), 0);
  EXPECT_LT(absl::Now() - begin, absl::Seconds(15)) << "its shards were not taken away";
}

TEST(FleetClusterTest, EpisodesAreReturnedDespiteLostNodes) {
  constexpr int32_t kEnvCount = 8;
  const TemporaryFolder folder;
  TestFleet fleet({absl::StrCat("--state_dir=", folder.path())});
  fleet.StartNode("a");
  fleet.StartNode("b");
  fleet.StartFleet(2);
  const auto client = fleet.Connect();
  v1::PoolSpec spec;
  spec.add_games("bigfish");
  spec.set_env_count(kEnvCount);
  spec.mutable_options()->set_rand_seed(3);  // no fish is eaten just before the end
  const auto pool = client->CreatePool(spec);
  ASSERT_THAT(pool, IsOk());
  const auto stream = client->Attach(pool->name());
  ASSERT_THAT(stream, IsOk());
  procgen_client::Batch batch;
  const auto step = [&](int32_t action) {
    ASSERT_THAT((*stream)->Step(std::vector<int32_t>(kEnvCount, action), &batch), IsOk());
  };
  const auto expect_played_again = [&](v1::EpisodeSelector selector) {
    for (int32_t i = 0; i < kEnvCount; ++i) {
      const auto episode = client->GetEpisode(pool->name(), i, selector);
      ASSERT_THAT(episode, IsOk());
      ExpectReplayIsEqual(*episode);
    }
  };
  expect_played_again(v1::EPISODE_SELECTOR_CURRENT);  // before the first step
  for (int32_t i = 0; i < 60; ++i) {
    step(i == 20 ? -1 : i % 9);
    if (i == 40) {
      fleet.KillNode("a");
    }
  }
  expect_played_again(v1::EPISODE_SELECTOR_LAST);
  expect_played_again(v1::EPISODE_SELECTOR_CURRENT);

  fleet.KillFleet();
  fleet.StartFleet(1);
  step(3);
  const auto lacking = client->GetEpisode(pool->name(), 0, v1::EPISODE_SELECTOR_CURRENT);
  ASSERT_THAT(lacking, IsOk());
  EXPECT_EQ(lacking->incomplete_reason(), v1::INCOMPLETE_REASON_SERVER_RESTARTED);
  step(-1);
  step(5);
  expect_played_again(v1::EPISODE_SELECTOR_CURRENT);
}

TEST(FleetClusterTest, FleetPoolsCanBeWatched) {
  TestFleet fleet;
  fleet.StartNode("a");
  fleet.StartNode("b");
  fleet.StartFleet(2);
  const auto client = fleet.Connect();
  const auto pool = client->CreatePool(Script().spec);
  ASSERT_THAT(pool, IsOk());
  const auto stream = client->Attach(pool->name());
  ASSERT_THAT(stream, IsOk());
  v1::WatchPoolRequest request;
  request.set_pool(pool->name());
  request.add_environments(pool->spec().env_count() - 1);
  request.add_environments(0);
  for (const int32_t size_px : {64, 100}) {
    request.set_size_px(size_px);
    const auto watch = client->Watch(request);
    ASSERT_THAT(watch->Next(), IsOk());
    procgen_client::Batch batch;
    ASSERT_THAT((*stream)->Step(
                    std::vector<int32_t>(static_cast<size_t>((*stream)->env_count()), 7), &batch),
                IsOk());
    const auto response = watch->Next();
    ASSERT_THAT(response, IsOk());
    EXPECT_EQ(response->sequence_number(), batch.sequence_number());
    const auto rendered = client->RenderEnvironments(pool->name(), {0}, 100);
    ASSERT_THAT(rendered, IsOk());
    const absl::Span<const uint8_t> observed = batch.observations().subspan(0, kObservationBytes);
    EXPECT_EQ(response->frames(1).image(), size_px == 64
                                               ? std::string(observed.begin(), observed.end())
                                               : rendered->frames(0).image());
  }
}

struct Restart {
  v1::Encoding encoding;
  bool is_killed = true;  // false: stopped by SIGTERM
};

class FleetRestartTest : public testing::TestWithParam<Restart> {};

TEST_P(FleetRestartTest, RestartedFleetServerContinues) {
  const TemporaryFolder folder;
  TestFleet fleet({absl::StrCat("--state_dir=", folder.path())});
  fleet.StartNode("a");
  fleet.StartNode("b");
  fleet.StartFleet(2);
  LearnerScript script = Script();
  script.with_states = false;  // the client does not retry those calls
  script.spec.set_encoding(GetParam().encoding);
  std::thread operator_thread;
  ExpectSameTrace(script, fleet, [&](int index) {
    if (index % 500 != 250) {
      return;
    }
    if (operator_thread.joinable()) {
      operator_thread.join();
    }
    // Restart while requests are running.
    operator_thread = std::thread([&fleet] {
      if (GetParam().is_killed) {
        fleet.KillFleet();
      } else {
        const absl::Time begin = absl::Now();
        fleet.StopFleet();
        EXPECT_LT(absl::Now() - begin, absl::Seconds(15)) << "the drain waited for the learner";
      }
      fleet.StartFleet(2);
    });
  });
  operator_thread.join();
}

INSTANTIATE_TEST_SUITE_P(KilledAndStopped, FleetRestartTest,
                         testing::Values(Restart{v1::ENCODING_RAW, true},
                                         Restart{v1::ENCODING_DELTA_ZSTD, true},
                                         Restart{v1::ENCODING_RAW, false}));

TEST(FleetFlagsTest, InvalidFlagsAreReported) {
  for (const auto& [flags, message] :
       {std::pair<std::vector<std::string>, std::string>({"--fleet"}, "--cluster"),
        std::pair<std::vector<std::string>, std::string>({"--state_dir=/tmp"},
                                                         "--fleet is missing"),
        std::pair<std::vector<std::string>, std::string>(
            {"--fleet", "--cluster=x", "--fleet_token=/nowhere"}, "--fleet_token is /nowhere")}) {
    ServerProcess process(flags);
    EXPECT_EQ(process.Address(), "");
    EXPECT_EQ(process.Wait(), 2);
    EXPECT_NE(process.beginning().find(message), std::string::npos) << process.beginning();
  }
}

}  // namespace
}  // namespace procgen
