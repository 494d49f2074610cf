// GetEpisode: a replay of the returned episode equals the original.

#include <memory>
#include <random>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/wire/convert_pool.h"
#include "tests/service/service_fixture.h"
#include "tests/service/states/episode_replay.h"

namespace procgen {
namespace {

using testing::_;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;

constexpr int32_t kEnvCount = 3;

v1::RunPoolRequest Unobserved(const std::vector<int32_t>& actions) {
  v1::RunPoolRequest request = StepRequest(actions);
  request.mutable_step()->set_observation(v1::OBSERVATION_NONE);
  return request;
}

class EpisodesTest : public ServiceTest {
 protected:
  v1::Episode Read(const std::string& pool, int32_t environment, v1::EpisodeSelector selector) {
    const auto episode = client_->GetEpisode(pool, environment, selector);
    EXPECT_THAT(episode, IsOk());
    return episode.value_or(v1::Episode());
  }
  v1::Episode Last(const std::string& pool, int32_t environment = 0) {
    return Read(pool, environment, v1::EPISODE_SELECTOR_LAST);
  }
  v1::Episode Current(const std::string& pool, int32_t environment = 0) {
    return Read(pool, environment, v1::EPISODE_SELECTOR_CURRENT);
  }
};

class EveryGameEpisodesTest : public EpisodesTest,
                              public testing::WithParamInterface<std::string> {};

TEST_P(EveryGameEpisodesTest, EpisodesAreReplayedInEachMode) {
  std::vector<DistributionMode> modes(FindGame(GetParam())->modes.begin(),
                                      FindGame(GetParam())->modes.end());
  if (FindGame(GetParam())->exploration_level.has_value()) {
    modes.push_back(DistributionMode::kExploration);
  }
  for (const DistributionMode mode : modes) {
    v1::PoolSpec spec;
    spec.add_games(GetParam());
    spec.set_env_count(kEnvCount);
    spec.mutable_options()->set_rand_seed(5);
    spec.mutable_options()->set_distribution_mode(DistributionModeMessageOf(mode));
    const auto stream = StartPool(spec);
    std::minstd_rand random(7);
    v1::Batch batch;
    for (int32_t step = 0; step < 150; ++step) {
      std::vector<int32_t> actions;
      actions.reserve(kEnvCount);
      for (int32_t i = 0; i < kEnvCount; ++i) {
        actions.push_back(random() % 50 == 0 ? -1 : static_cast<int32_t>(random() % 15));
      }
      ASSERT_THAT(stream->Call(Unobserved(actions), &batch), IsOk());
      for (int32_t i = 0; i < kEnvCount && step % 10 == 9; ++i) {
        const auto episode = client_->GetEpisode(stream->name(), i);
        if (!absl::IsFailedPrecondition(episode.status())) {
          ASSERT_THAT(episode, IsOk());
          ExpectReplayIsEqual(*episode);
        }
      }
    }
    for (int32_t i = 0; i < kEnvCount; ++i) {
      ExpectReplayIsEqual(Last(stream->name(), i));
      ExpectReplayIsEqual(Current(stream->name(), i));
    }
    ASSERT_THAT(stream->Close(), IsOk());
  }
}

std::vector<std::string> AllGames() {
  std::vector<std::string> games;
  for (const GameSpec& spec : GameCatalog()) {
    games.emplace_back(spec.name);
  }
  return games;
}

INSTANTIATE_TEST_SUITE_P(Games, EveryGameEpisodesTest, testing::ValuesIn(AllGames()),
                         [](const auto& info) { return info.param; });

TEST_F(EpisodesTest, EpisodeHasActionsAndRewards) {
  const auto stream = StartPool(MazeSpec(2));
  const std::string pool = stream->name();
  v1::Batch batch;
  ASSERT_THAT(stream->Observe(&batch), IsOk());
  const int32_t level_seed = batch.level_seeds()[1];
  EXPECT_EQ(Current(pool, 1).level_seed(), level_seed);
  EXPECT_THAT(client_->GetEpisode(pool, 1), StatusIs(absl::StatusCode::kFailedPrecondition,
                                                     "environment 1 has ended no episode yet"));
  ASSERT_THAT(stream->Step({7, 3}, &batch), IsOk());
  ASSERT_THAT(stream->Step({7, 14}, &batch), IsOk());
  ASSERT_THAT(stream->Step({7, -1}, &batch), IsOk());
  ASSERT_THAT(stream->Step({7, 1}, &batch), IsOk());
  const v1::Episode last = Last(pool, 1);
  EXPECT_EQ(last.environment(), 1);
  EXPECT_EQ(last.game(), "maze");
  EXPECT_EQ(last.level_seed(), level_seed);
  EXPECT_EQ(last.options().start_level(), level_seed);
  EXPECT_EQ(last.options().num_levels(), 1);
  EXPECT_EQ(last.actions(), std::string("\x03\x0e\xff"));
  EXPECT_THAT(last.rewards(), SizeIs(3));
  EXPECT_THAT(last.action_counts(), IsEmpty());
  EXPECT_EQ(last.outcome(), v1::EPISODE_OUTCOME_TERMINATED);
  const v1::Episode current = Current(pool, 1);
  EXPECT_EQ(current.level_seed(), batch.level_seeds()[1]);
  EXPECT_EQ(current.actions(), std::string("\x01"));
  EXPECT_EQ(current.outcome(), v1::EPISODE_OUTCOME_UNDER_WAY);
}

TEST_F(EpisodesTest, RepeatedActionsAreRecordedOneByOne) {
  v1::PoolSpec spec = MazeSpec(1);
  spec.set_games(0, "bigfish");
  const auto stream = StartPool(spec);
  std::minstd_rand random(3);
  v1::Batch batch;
  for (int32_t step = 0; step < 300; ++step) {
    v1::RunPoolRequest request = Unobserved({static_cast<int32_t>(random() % 9)});
    request.mutable_step()->set_repeat_count(1 + static_cast<int32_t>(random() % 6));
    ASSERT_THAT(stream->Call(request, &batch), IsOk());
  }
  const v1::Episode last = Last(stream->name());
  EXPECT_EQ(last.action_counts_size(), last.rewards_size());
  ExpectReplayIsEqual(last);
  ExpectReplayIsEqual(Current(stream->name()));
}

TEST_F(EpisodesTest, LevelsOfASequenceAreReported) {
  v1::PoolSpec spec = MazeSpec(4);
  spec.set_games(0, "leaper");
  spec.mutable_options()->set_use_sequential_levels(true);
  for (int32_t seed = 10; seed < 30; ++seed) {
    spec.mutable_level_sampler()->add_level_seeds(seed);
  }
  const auto stream = StartPool(spec);
  v1::Batch batch;
  int levels = 0;
  std::minstd_rand random(11);
  for (int32_t step = 0; step < 1500; ++step) {
    std::vector<int32_t> actions;
    actions.reserve(4);
    for (int32_t i = 0; i < 4; ++i) {
      actions.push_back(random() % 4 == 0 ? 4 : 5);
    }
    ASSERT_THAT(stream->Call(Unobserved(actions), &batch), IsOk());
    for (int32_t i = 0; i < 4; ++i) {
      if (batch.prev_level_complete(i)) {
        const v1::Episode current = Current(stream->name(), i);
        ExpectReplayIsEqual(current);
        levels += current.level_changes_size();
      }
    }
  }
  EXPECT_GT(levels, 0);
}

TEST_F(EpisodesTest, SlicesMayBeSteppedInTurn) {
  const auto stream = StartPool(MazeSpec(4));
  v1::Batch batch;
  for (int32_t step = 0; step < 100; ++step) {
    ASSERT_THAT(stream->Call(SliceStepRequest(0, 2, step % 15), &batch), IsOk());
    if (step % 3 == 0) {
      ASSERT_THAT(stream->Call(SliceStepRequest(1, 3, step == 60 ? -1 : 7), &batch), IsOk());
    }
  }
  for (int32_t i = 0; i < 4; ++i) {
    ExpectReplayIsEqual(Current(stream->name(), i));
  }
  EXPECT_THAT(Current(stream->name(), 0).actions(), SizeIs(100));
  EXPECT_THAT(Last(stream->name(), 3).actions(), SizeIs(21));
  ExpectReplayIsEqual(Last(stream->name(), 1));
}

TEST_F(EpisodesTest, ResetEndsAnEpisodeThatWasStepped) {
  const auto stream = StartPool(MazeSpec(2));
  const std::string pool = stream->name();
  v1::Batch batch;
  ASSERT_THAT(stream->Step({7, 7}, &batch), IsOk());
  v1::RunPoolRequest reset = ResetRequest(2);
  reset.mutable_reset()->add_resets()->set_environment(0);
  reset.mutable_reset()->mutable_resets(0)->set_level_seed(-5);
  for (int32_t i = 0; i < 2; ++i) {  // the second reset ends an episode without steps
    ASSERT_THAT(stream->Call(reset, &batch), IsOk());
  }
  EXPECT_EQ(Last(pool).outcome(), v1::EPISODE_OUTCOME_RESET);
  EXPECT_EQ(Last(pool).actions(), std::string("\x07"));
  ExpectReplayIsEqual(Last(pool));
  EXPECT_THAT(Current(pool).actions(), IsEmpty());
  // A reset within a step; the other environment is stepped.
  v1::RunPoolRequest step = StepRequest({3, 5});
  *step.mutable_step()->add_resets() = reset.reset().resets(0);
  ASSERT_THAT(stream->Step({2, 4}, &batch), IsOk());
  ASSERT_THAT(stream->Call(step, &batch), IsOk());
  EXPECT_EQ(Last(pool).actions(), std::string("\x02"));
  EXPECT_EQ(Last(pool).level_seed(), -5);
  EXPECT_EQ(Current(pool, 1).actions(), std::string("\x07\x04\x05"));
  ASSERT_THAT(stream->Step({8, 8}, &batch), IsOk());
  EXPECT_EQ(Current(pool).actions(), std::string("\x08"));
  ExpectReplayIsEqual(Current(pool));
}

TEST_F(EpisodesTest, IgnoredActionsBelongToNoEpisode) {
  v1::PoolSpec spec = MazeSpec(1);
  spec.set_autoreset_mode(v1::AUTORESET_MODE_NEXT_STEP);
  const auto stream = StartPool(spec);
  const std::string pool = stream->name();
  v1::Batch batch;
  ASSERT_THAT(stream->Step({3}, &batch), IsOk());
  ASSERT_THAT(stream->Step({-1}, &batch), IsOk());
  EXPECT_THAT(client_->GetEpisode(pool, 0, v1::EPISODE_SELECTOR_CURRENT),
              StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("between two episodes")));
  ASSERT_THAT(stream->Step({9}, &batch), IsOk());
  EXPECT_THAT(Current(pool).actions(), IsEmpty());
  ASSERT_THAT(stream->Step({6}, &batch), IsOk());
  EXPECT_EQ(Current(pool).actions(), std::string("\x06"));
  EXPECT_EQ(Last(pool).actions(), std::string("\x03\xff"));
  ExpectReplayIsEqual(Last(pool));
  ExpectReplayIsEqual(Current(pool));
}

TEST_F(EpisodesTest, RestoredStatesAreReportedAndTheNextEpisodeIsWhole) {
  const auto stream = StartPool(MazeSpec(2));
  const std::string pool = stream->name();
  v1::PoolSpec other_spec = MazeSpec(1);
  other_spec.mutable_options()->set_distribution_mode(v1::DISTRIBUTION_MODE_HARD);
  const auto other = StartPool(other_spec);
  v1::Batch batch;
  const auto fresh = other->Save();
  ASSERT_THAT(other->Step({5}, &batch), IsOk());
  const auto later = other->Save();
  ASSERT_THAT(fresh, IsOk());
  ASSERT_THAT(later, IsOk());
  ASSERT_THAT(stream->Step({7, 7}, &batch), IsOk());
  ASSERT_THAT(stream->Restore(*later), IsOk());
  ASSERT_THAT(stream->Step({2, 3}, &batch), IsOk());
  EXPECT_EQ(Current(pool).incomplete_reason(), v1::INCOMPLETE_REASON_STATE_RESTORED);
  EXPECT_EQ(Current(pool).actions(), std::string("\x02"));
  ASSERT_THAT(stream->Step({-1, 3}, &batch), IsOk());
  EXPECT_EQ(Last(pool).incomplete_reason(), v1::INCOMPLETE_REASON_STATE_RESTORED);
  // The next episode has the options of the restored state.
  ASSERT_THAT(stream->Step({4, 3}, &batch), IsOk());
  EXPECT_EQ(Current(pool).options().distribution_mode(), v1::DISTRIBUTION_MODE_HARD);
  ExpectReplayIsEqual(Current(pool));
  // A state at the start of an episode gives a complete episode.
  ASSERT_THAT(stream->Restore(*fresh), IsOk());
  ASSERT_THAT(stream->Step({1, 3}, &batch), IsOk());
  EXPECT_EQ(Current(pool).actions(), std::string("\x01"));
  ExpectReplayIsEqual(Current(pool));
  // A cloned state counts as restored.
  ASSERT_THAT(stream->Clone({Pair(0, 1)}), IsOk());
  EXPECT_EQ(Current(pool, 1).incomplete_reason(), v1::INCOMPLETE_REASON_STATE_RESTORED);
  ASSERT_THAT(stream->Step({1, -1}, &batch), IsOk());
  ASSERT_THAT(stream->Step({1, 4}, &batch), IsOk());
  EXPECT_EQ(Current(pool, 1).options().distribution_mode(), v1::DISTRIBUTION_MODE_HARD);
  ExpectReplayIsEqual(Current(pool, 1));
}

TEST_F(EpisodesTest, InvalidArgumentsAreRejected) {
  const auto stream = StartPool(MazeSpec(2));
  const std::string& pool = stream->name();
  EXPECT_THAT(client_->GetEpisode(pool, 2),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "environment is 2, pool " + pool + " has environments 0 to 1"));
  EXPECT_THAT(client_->GetEpisode(pool, -1), StatusIs(absl::StatusCode::kInvalidArgument, _));
  EXPECT_THAT(client_->GetEpisode("pools/nothing", 0), StatusIs(absl::StatusCode::kNotFound, _));
  EXPECT_THAT(client_->GetEpisode(pool, 0, static_cast<v1::EpisodeSelector>(9)),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("selector")));
}

}  // namespace
}  // namespace procgen
