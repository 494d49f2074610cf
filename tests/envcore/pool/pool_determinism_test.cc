// Worker count, slices, pool size and shards change no bit of any result: for every game, in each
// of its modes.

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "envcore/pool/pool.h"
#include "envcore/random/random_stream.h"
#include "gtest/gtest.h"
#include "tests/envcore/pool/batch_buffers.h"

namespace procgen {
namespace {

constexpr int32_t kEnvCount = 6;
constexpr int kStepCount = 60;

struct Played {
  std::string name;
  std::vector<std::string> games;
  DistributionMode mode;
  ObservationFormat observation_format = {};
};

std::vector<Played> AllThatCanBePlayed() {
  std::vector<Played> all;
  std::vector<std::string> joint;
  for (const GameSpec& game : GameCatalog()) {
    for (const DistributionMode mode : game.modes) {
      all.push_back({absl::StrCat(game.name, "_", DistributionModeName(mode)),
                     {std::string(game.name)},
                     mode,
                     {}});
    }
    if (joint.size() < 3) {
      joint.emplace_back(game.name);
    }
  }
  all.push_back({"joint", joint, DistributionMode::kEasy, {}});
  ObservationFormat stacked;
  stacked.frame = {.size_px = 84, .color = Color::kGrayscale};
  stacked.frame_stack = 4;
  all.push_back({"stacked", joint, DistributionMode::kEasy, stacked});
  return all;
}

// The actions of environment i of the whole pool, independent of the pool it is in. Some end the
// episode.
std::vector<int32_t> ActionsOf(int32_t environment) {
  RandomStream random(environment);
  std::vector<int32_t> actions;
  for (int step = 0; step < kStepCount; ++step) {
    const int32_t action = random.Int(kActionCount + 1) - 1;
    actions.push_back(action == kEndEpisodeAction && step % 4 != 0 ? kNoAction : action);
  }
  return actions;
}

PoolOptions OptionsOf(const Played& played, int32_t env_count) {
  PoolOptions options;
  options.games = played.games;
  options.env_count = env_count;
  options.environment.distribution_mode = played.mode;
  options.environment.rand_seed = 99;
  options.observation_format = played.observation_format;
  return options;
}

// The results of all environments of `pool`, at the start and after each step. Steps in slices of
// `slice` environments, the last slice first.
std::vector<BatchBuffers> Play(Pool& pool, int32_t slice) {
  const int32_t env_count = pool.env_count();
  std::vector<std::vector<int32_t>> actions;
  actions.reserve(static_cast<size_t>(env_count));
  for (int32_t i = 0; i < env_count; ++i) {
    actions.push_back(ActionsOf(pool.options().first_env + i));
  }
  std::vector<BatchBuffers> results;
  BatchBuffers buffers(env_count, pool.observation_bytes());
  EXPECT_TRUE(pool.Observe(0, env_count, buffers.Whole()).ok());
  results.push_back(buffers);
  for (size_t step = 0; step < kStepCount; ++step) {
    for (int32_t first = (env_count - 1) / slice * slice; first >= 0; first -= slice) {
      const int32_t count = std::min(slice, env_count - first);
      std::vector<int32_t> row;
      for (int32_t i = first; i < first + count; ++i) {
        row.push_back(actions[static_cast<size_t>(i)][step]);
      }
      EXPECT_TRUE(
          pool.Step({.first = first, .count = count, .actions = row}, buffers.Rows(first, count))
              .ok());
    }
    results.push_back(buffers);
  }
  return results;
}

std::vector<BatchBuffers> Play(const PoolOptions& options, int32_t thread_count, int32_t slice) {
  auto pool = Pool::Create(options, std::make_shared<WorkerPool>(thread_count));
  EXPECT_TRUE(pool.ok()) << pool.status();
  return Play(**pool, slice);
}

// The rows [begin, begin + count) of each batch.
template <typename T>
std::vector<T> RowsOf(const std::vector<T>& values, size_t begin, size_t count, size_t width) {
  const auto start = values.begin() + static_cast<std::ptrdiff_t>(begin * width);
  return {start, start + static_cast<std::ptrdiff_t>(count * width)};
}

std::vector<BatchBuffers> RowsOf(const std::vector<BatchBuffers>& batches, size_t begin,
                                 size_t count) {
  std::vector<BatchBuffers> rows;
  for (const BatchBuffers& batch : batches) {
    BatchBuffers& part = rows.emplace_back(0, batch.observation_bytes);
    part.observations = RowsOf(batch.observations, begin, count, batch.observation_bytes);
#define PROCGEN_ROWS(type, name, member) part.name = RowsOf(batch.name, begin, count, 1);
    PROCGEN_BATCH_NUMBERS(PROCGEN_ROWS)
#undef PROCGEN_ROWS
    part.final_observations =
        RowsOf(batch.final_observations, begin, count, batch.observation_bytes);
  }
  return rows;
}

class PoolDeterminismTest : public testing::TestWithParam<Played> {};

// One test, because all compare with the same results.
TEST_P(PoolDeterminismTest, WorkersSlicesPoolSizeAndShardsChangeNothing) {
  const PoolOptions options = OptionsOf(GetParam(), kEnvCount);
  const std::vector<BatchBuffers> whole = Play(options, 0, kEnvCount);
  EXPECT_TRUE(Play(options, 0, kEnvCount) == whole) << "an equal pool";
  EXPECT_TRUE(Play(options, 3, kEnvCount) == whole) << "more workers";
  EXPECT_TRUE(Play(options, 1, 1) == whole) << "slices of one";
  EXPECT_TRUE(Play(options, 0, 4) == whole) << "slices of four and two";
  const auto larger = Play(OptionsOf(GetParam(), 2 * kEnvCount), 1, 2 * kEnvCount);
  EXPECT_TRUE(RowsOf(larger, 0, kEnvCount) == whole) << "a larger pool";
  for (const auto& [first, count] :
       std::vector<std::pair<int32_t, int32_t>>{{0, 2}, {2, 1}, {3, 3}}) {
    PoolOptions shard = OptionsOf(GetParam(), count);
    shard.first_env = first;
    shard.total_env_count = kEnvCount;
    EXPECT_TRUE(Play(shard, 1, count) ==
                RowsOf(whole, static_cast<size_t>(first), static_cast<size_t>(count)))
        << "a shard from " << first;
  }
}

INSTANTIATE_TEST_SUITE_P(Catalog, PoolDeterminismTest, testing::ValuesIn(AllThatCanBePlayed()),
                         [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace procgen
