// Saving and restoring over gRPC: a restored environment continues like an uninterrupted one.

#include <algorithm>
#include <string>
#include <vector>

#include "envcore/pool/pool.h"
#include "envcore/random/random_stream.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/service/service_fixture.h"

namespace procgen {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::SizeIs;

constexpr int32_t kSavedCount = 3;
constexpr int32_t kOtherCount = 5;
constexpr int kStepsAfter = 40;

// Random actions for the first `count` environments; one in 20 ends the episode.
v1::RunPoolRequest RandomStep(RandomStream* random, int32_t count) {
  v1::RunPoolRequest request = SliceStepRequest(0, count, 0);
  for (int32_t& action : *request.mutable_step()->mutable_actions()) {
    action = random->Int(kActionCount);
    if (random->Int(20) == 0) {
      action = kEndEpisodeAction;
    }
  }
  request.mutable_step()->set_with_final_observations(true);
  return request;
}

// Batches of the first `count` environments: of an observe, then of each of `steps` random steps.
std::vector<v1::Batch> Played(PoolStream* run, int64_t seed, int32_t count, int steps) {
  RandomStream random(seed);
  std::vector<v1::Batch> played(1);
  EXPECT_THAT(run->Call(ObserveRequest(count), &played.back()), IsOk());
  for (int step = 0; step < steps; ++step) {
    EXPECT_THAT(run->Call(RandomStep(&random, count), &played.emplace_back()), IsOk());
  }
  return played;
}

void ExpectEqual(const std::vector<v1::Batch>& left, const std::vector<v1::Batch>& right) {
  EXPECT_TRUE(std::equal(left.begin(), left.end(), right.begin(), right.end(), EqualMessages));
}

class StatesTest : public ServiceTest {
 protected:
  // The states of all environments.
  static std::vector<v1::State> Saved(PoolStream* run) {
    absl::StatusOr<std::vector<v1::State>> states = run->Save();
    EXPECT_THAT(states, IsOk());
    return states.ok() ? *std::move(states) : std::vector<v1::State>();
  }
  static std::vector<std::string> Snapshots(PoolStream* run) {
    std::vector<std::string> snapshots;
    for (const v1::State& state : Saved(run)) {
      snapshots.push_back(state.snapshot());
    }
    return snapshots;
  }
};

class EveryGameStatesTest : public StatesTest, public testing::WithParamInterface<std::string> {};

TEST_P(EveryGameStatesTest, RestoredStatesOnAnotherServerContinueAsTheOriginals) {
  v1::PoolSpec spec = MazeSpec(kSavedCount);
  *spec.mutable_games(0) = GetParam();
  v1::PoolSpec other_spec = spec;
  other_spec.set_env_count(kOtherCount);
  other_spec.mutable_options()->set_distribution_mode(v1::DISTRIBUTION_MODE_HARD);
  other_spec.mutable_options()->set_use_monochrome_assets(true);
  const auto other_server = StartServer(/*worker_count=*/1);
  PoolStream other(ChannelTo(other_server->address()));
  ASSERT_THAT(other.Start(other_spec), IsOk());
  const auto run = StartPool(spec);

  for (const int steps_between : {0, 23, 61}) {
    Played(run.get(), steps_between, kSavedCount, steps_between);
    Played(&other, 6, kOtherCount, 7);
    std::vector<v1::State> states = Saved(run.get());
    ASSERT_THAT(states, SizeIs(kSavedCount));
    std::swap(states.front(), states.back());
    ASSERT_THAT(other.Restore(states), IsOk());
    PoolStream started(ChannelTo(other_server->address()));
    ASSERT_THAT(started.Start(other_spec, states), IsOk());

    const auto continued = Played(run.get(), 9, kSavedCount, kStepsAfter);
    ExpectEqual(Played(&other, 9, kSavedCount, kStepsAfter), continued);
    ExpectEqual(Played(&started, 9, kSavedCount, kStepsAfter), continued);
  }
}

std::vector<std::string> AllGames() {
  std::vector<std::string> games;
  for (const GameSpec& spec : GameCatalog()) {
    games.emplace_back(spec.name);
  }
  return games;
}

INSTANTIATE_TEST_SUITE_P(Games, EveryGameStatesTest, testing::ValuesIn(AllGames()),
                         [](const auto& info) { return info.param; });

TEST_F(StatesTest, EpisodesEndDuringTheComparison) {
  const auto stream = StartPool(MazeSpec(kSavedCount));
  size_t ended = 0;
  for (const v1::Batch& batch : Played(stream.get(), 9, kSavedCount, kStepsAfter)) {
    ended += static_cast<size_t>(batch.fingerprints_size());
  }
  EXPECT_GT(ended, 0U);
}

TEST_F(StatesTest, SavingChangesNothing) {
  const auto run = StartPool(MazeSpec(3));
  v1::Batch before;
  ASSERT_THAT(run->Step({7, 7, 7}, &before), IsOk());
  ASSERT_THAT(run->Observe(&before), IsOk());
  const auto states = run->Save({2, 0});
  ASSERT_THAT(states, IsOk());
  ASSERT_THAT(*states, SizeIs(2));
  EXPECT_EQ(states->front().environment(), 2);
  EXPECT_EQ(states->back().environment(), 0);
  v1::Batch batch;
  ASSERT_THAT(run->Observe(&batch), IsOk());
  EXPECT_TRUE(EqualMessages(batch, before));
}

TEST_F(StatesTest, ClonesExchangeStates) {
  const auto run = StartPool(MazeSpec(4));
  const std::vector<std::string> before = Snapshots(run.get());
  ASSERT_THAT(run->Clone({Pair(0, 1), Pair(1, 0), Pair(0, 3)}), IsOk());
  EXPECT_THAT(Snapshots(run.get()), ElementsAre(before[1], before[0], before[2], before[0]));
}

TEST_F(StatesTest, NextLevelAfterARestoredEpisodeFollowsThePool) {
  v1::PoolSpec spec = MazeSpec(1);
  spec.set_autoreset_mode(v1::AUTORESET_MODE_NEXT_STEP);
  const auto ending = StartPool(spec);
  v1::Batch batch;
  ASSERT_THAT(ending->Step({-1}, &batch), IsOk());
  spec.set_autoreset_mode(v1::AUTORESET_MODE_DISABLED);
  const auto run = StartPool(spec);
  ASSERT_THAT(run->Restore(Saved(ending.get())), IsOk());
  EXPECT_THAT(run->Step({4}, &batch), StatusIs(absl::StatusCode::kFailedPrecondition,
                                               HasSubstr("the episode of environment 0 of pool " +
                                                         run->name() + " has ended")));
}

TEST_F(StatesTest, AutoresetEpisodeNeedsNoReset) {
  const auto source = StartPool(MazeSpec(1));
  v1::Batch batch;
  ASSERT_THAT(source->Step({-1}, &batch), IsOk());
  v1::PoolSpec spec = MazeSpec(1);
  spec.set_autoreset_mode(v1::AUTORESET_MODE_DISABLED);
  const auto run = StartPool(spec);
  ASSERT_THAT(run->Restore(Saved(source.get())), IsOk());
  ASSERT_THAT(run->Observe(&batch), IsOk());
  EXPECT_THAT(batch.terminated(), ElementsAre(true));
  EXPECT_THAT(run->Step({4}, &batch), IsOk());
}

TEST_F(StatesTest, RestoredEndedEnvironmentCanBeStepped) {
  v1::PoolSpec spec = MazeSpec(1);
  spec.set_autoreset_mode(v1::AUTORESET_MODE_DISABLED);
  const auto run = StartPool(spec);
  const std::vector<v1::State> running = Saved(run.get());
  v1::Batch batch;
  ASSERT_THAT(run->Step({-1}, &batch), IsOk());
  ASSERT_THAT(run->Restore(running), IsOk());
  EXPECT_THAT(run->Step({4}, &batch), IsOk());
}

TEST_F(StatesTest, StatesBeyondAResponseAreRejected) {
  Limits limits = TestLimits();
  limits.response_bytes_max = 65536;
  const auto small = StartServer(/*worker_count=*/1, limits);
  ASSERT_NE(small, nullptr);
  PoolStream run(ChannelTo(small->address()));
  ASSERT_THAT(run.Start(MazeSpec(300)), IsOk());
  EXPECT_THAT(run.Save({0, 1, 2}), IsOk());
  EXPECT_THAT(run.Save(), StatusIs(absl::StatusCode::kResourceExhausted,
                                   HasSubstr("limit response_bytes_max is 65536; save fewer")));
}

}  // namespace
}  // namespace procgen
