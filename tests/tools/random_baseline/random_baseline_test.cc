#include "tools/random_baseline/random_baseline.h"

#include <algorithm>
#include <memory>
#include <numeric>
#include <string>
#include <vector>

#include "absl/types/span.h"
#include "envcore/pool/pool.h"
#include "envcore/pool/worker_pool.h"
#include "envcore/random/random_stream.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/program_run.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using ::testing::HasSubstr;

ReturnStatistics Play(const GameMode& game_mode, const RandomPlay& play) {
  const auto statistics = PlayRandomly(game_mode, play, [](int64_t) {});
  EXPECT_THAT(statistics, IsOk());
  return statistics.value_or(ReturnStatistics());
}

const GameMode kCoinRun = {.game = FindGame("coinrun"), .mode = DistributionMode::kEasy};

TEST(RandomBaselineTest, ResultsDoNotDependOnTheNumberOfWorkers) {
  RandomPlay play = {.env_count = 4, .episodes_per_environment = 3, .worker_count = 1, .seed = 7};
  const ReturnStatistics alone = Play(kCoinRun, play);
  play.worker_count = 3;
  const ReturnStatistics together = Play(kCoinRun, play);
  EXPECT_EQ(alone.episode_count, 12);
  EXPECT_EQ(together.return_mean, alone.return_mean);
  EXPECT_EQ(together.length_mean, alone.length_mean);
}

// The length of the first episode of each environment, from an independent loop.
std::vector<int32_t> FirstEpisodeLengths(const GameMode& game_mode, size_t env_count) {
  PoolOptions options;
  options.games = {std::string(game_mode.game->name)};
  options.env_count = static_cast<int32_t>(env_count);
  options.environment.distribution_mode = game_mode.mode;
  const auto pool = Pool::Create(options, std::make_shared<WorkerPool>(0)).value();
  RandomStream random(0);
  std::vector<int32_t> actions(env_count);
  std::vector<uint8_t> first(env_count);
  std::vector<int32_t> lengths(env_count, 0);
  Batch batch;
  batch.first = absl::MakeSpan(first);
  for (int32_t step = 1; std::count(lengths.begin(), lengths.end(), 0) > 0; ++step) {
    std::generate(actions.begin(), actions.end(), [&] { return random.Int(kActionCount); });
    EXPECT_THAT(pool->Step({.count = options.env_count, .actions = actions}, batch), IsOk());
    for (size_t i = 0; i < env_count; ++i) {
      if (first[i] != 0 && lengths[i] == 0) {
        lengths[i] = step;
      }
    }
  }
  return lengths;
}

TEST(RandomBaselineTest, LongFirstEpisodesCountAsMuchAsShortOnes) {
  const RandomPlay play = {
      .env_count = 10, .episodes_per_environment = 1, .worker_count = 1, .seed = 0};
  const std::vector<int32_t> lengths = FirstEpisodeLengths(kCoinRun, 10);
  const double length_sum = std::accumulate(lengths.begin(), lengths.end(), 0.0);
  EXPECT_EQ(Play(kCoinRun, play).length_mean, length_sum / 10);
}

// If the returns are 10 or 0 with mean m, the variance is m (10 - m).
TEST(RandomBaselineTest, ReportsTheStandardErrorOfTheMean) {
  const RandomPlay play = {
      .env_count = 10, .episodes_per_environment = 10, .worker_count = 1, .seed = 1};
  const ReturnStatistics statistics = Play(kCoinRun, play);
  const double m = statistics.return_mean;
  EXPECT_GT(m, 0);
  EXPECT_NEAR(statistics.return_error * statistics.return_error, m * (10 - m) / 99, 1e-9);
}

TEST(ProcgenRandomBaselineTest, PrintsARowForEachGameAndMode) {
  const ProgramRun run = RunProgram(PROCGEN_RANDOM_BASELINE
                                    " --games leaper --environments 2 --episodes 2 --workers 1");
  EXPECT_EQ(run.exit_status, 0);
  EXPECT_THAT(run.output, HasSubstr("| leaper | easy | "));
  EXPECT_THAT(run.output, HasSubstr("| leaper | hard | "));
}

TEST(ProcgenRandomBaselineTest, WrongFlagsAreRejectedWithWhatIsAllowed) {
  EXPECT_THAT(RunProgram(PROCGEN_RANDOM_BASELINE " --episodes 0").output,
              HasSubstr("--episodes 0: both must be at least 1"));
  EXPECT_EQ(RunProgram(PROCGEN_RANDOM_BASELINE " --games pong").exit_status, 2);
}

}  // namespace
}  // namespace procgen
