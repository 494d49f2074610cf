#include "tests/service/states/episode_replay.h"

#include <bit>
#include <cstdint>
#include <memory>
#include <vector>

#include "envcore/pool/batch_numbers.h"
#include "envcore/pool/pool.h"
#include "gtest/gtest.h"
#include "server/wire/convert_pool.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

std::unique_ptr<Pool> PoolFor(const v1::Episode& episode) {
  v1::PoolSpec spec;
  spec.add_games(episode.game());
  spec.set_env_count(1);
  *spec.mutable_options() = episode.options();
  std::unique_ptr<Pool> pool =
      Pool::Create(PoolOptionsOf(spec).value(), std::make_shared<WorkerPool>(0)).value();
  if (episode.prev_level_incomplete()) {
    const int32_t action = 4;
    EXPECT_THAT(pool->Step({.count = 1, .actions = {&action, 1}}, {}), IsOk());
  }
  if (episode.prev_level_incomplete() || episode.options().num_levels() == 0) {
    const Reset reset = {
        .environment = 0, .level_seed = episode.level_seed(), .rand_seed = std::nullopt};
    EXPECT_THAT(pool->Step({.count = 1, .steps = false, .resets = {&reset, 1}}, {}), IsOk());
  }
  return pool;
}

}  // namespace

void ExpectReplayIsEqual(const v1::Episode& episode) {
  ASSERT_EQ(episode.incomplete_reason(), v1::INCOMPLETE_REASON_UNSPECIFIED);
  const std::unique_ptr<Pool> pool = PoolFor(episode);
  BatchNumbers values;
  values.ReplaceEmptyArrays({}, 1);  // a new episode has no step
  int32_t played = 0;
  int change = 0;
  for (int i = 0; i < episode.rewards_size(); ++i) {
    const int32_t count = episode.action_counts().empty() ? 1 : episode.action_counts(i);
    const auto byte = static_cast<int8_t>(episode.actions()[static_cast<size_t>(played)]);
    const int32_t action = byte;  // NOLINT(bugprone-signed-char-misuse): -1 is an action
    std::vector<NextLevel> next_levels;
    if (change < episode.level_changes_size() &&
        episode.level_changes(change).action() < played + count) {
      next_levels.push_back({0, episode.level_changes(change++).level_seed()});
    }
    ASSERT_THAT(
        pool->Step(
            {.count = 1, .actions = {&action, 1}, .repeat = count, .next_levels = next_levels},
            values.ReplaceEmptyArrays({}, 1)),
        IsOk());
    ASSERT_EQ(std::bit_cast<uint32_t>(values.rewards[0]),
              std::bit_cast<uint32_t>(episode.rewards(i)))
        << episode.game() << " level " << episode.level_seed() << " step " << i;
    played += count;
  }
  EXPECT_EQ(played, static_cast<int32_t>(episode.actions().size()));
  EXPECT_EQ(change, episode.level_changes_size());
  EXPECT_EQ(values.terminated[0] != 0, episode.outcome() == v1::EPISODE_OUTCOME_TERMINATED);
  EXPECT_EQ(values.truncated[0] != 0, episode.outcome() == v1::EPISODE_OUTCOME_TRUNCATED);
  EXPECT_EQ(std::bit_cast<uint32_t>(values.episode_returns[0]),
            std::bit_cast<uint32_t>(episode.total_reward()));
  if (values.terminated[0] != 0 || values.truncated[0] != 0) {
    EXPECT_EQ(static_cast<int64_t>(values.fingerprints[0]), episode.fingerprint());
    EXPECT_EQ(values.prev_level_complete[0] != 0, episode.level_complete());
  }
}

}  // namespace procgen
