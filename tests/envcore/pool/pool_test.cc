#include "envcore/pool/pool.h"

#include <atomic>
#include <functional>
#include <limits>
#include <memory>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "absl/synchronization/notification.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/envcore/pool/batch_buffers.h"
#include "tests/envcore/pool/small_pool.h"

namespace procgen {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;

// --- Creation.

void ExpectNoPool(const PoolOptions& options, absl::StatusCode code, const std::string& message) {
  const absl::Status status = Pool::Create(options, std::make_shared<WorkerPool>(0)).status();
  EXPECT_EQ(status.code(), code);
  EXPECT_EQ(status.message(), message);
}

TEST(PoolCreateTest, RejectsOptionsOutOfRangeAndNamesTheRange) {
  const auto invalid = absl::StatusCode::kInvalidArgument;
  ExpectNoPool(OptionsOf({}), invalid, "games is empty, must name at least one game");
  ExpectNoPool(OptionsOf({"maze"}, 0), invalid, "env_count is 0, must be at least 1");
  ExpectNoPool(OptionsOf({"maze", "miner"}, 3), invalid,
               "there are 3 environments for 2 games, must be a multiple of the number of games");
  PoolOptions options = OptionsOf({"maze"});
  options.first_env = -1;
  ExpectNoPool(options, invalid, "first_env is -1, must be at least 0");
  options.first_env = 2;
  options.total_env_count = 5;
  ExpectNoPool(options, invalid,
               "total_env_count is 5, must be at least first_env + env_count = 6, or 0");
  options.first_env = std::numeric_limits<int32_t>::max() - 3;
  options.total_env_count = 0;
  ExpectNoPool(options, invalid,
               "the whole pool has 2147483648 environments, must be at most 16777216");
}

TEST(PoolCreateTest, AShardsSizeNeedNotBeAMultipleOfTheGameCount) {
  PoolOptions options = OptionsOf({"maze", "miner"}, 1);
  options.first_env = 1;
  options.total_env_count = 4;
  EXPECT_EQ(MadePool(options)->env_count(), 1);
}

TEST(PoolCreateTest, GamesAreAssignedInTurn) {
  const BatchBuffers joint = Observed(*MadePool(OptionsOf({"maze", "miner"})));
  const BatchBuffers mazes = Observed(*MazePool());
  const BatchBuffers miners = Observed(*MadePool(OptionsOf({"miner"})));
  EXPECT_EQ(joint.level_seeds, mazes.level_seeds) << "streams do not depend on the games";
  const auto picture = [](const BatchBuffers& buffers, size_t i) {
    return RowOf(buffers.observations, kObservationBytes, i);
  };
  EXPECT_EQ(picture(joint, 0), picture(mazes, 0));
  EXPECT_EQ(picture(joint, 1), picture(miners, 1));
  EXPECT_EQ(picture(joint, 2), picture(mazes, 2));
  EXPECT_EQ(picture(joint, 3), picture(miners, 3));
}

// --- Steps.

TEST(PoolStepTest, WritesOnlyRequestedArrays) {
  const auto pool = MazePool();
  std::vector<float> rewards(kEnvCount, -1);
  Batch batch;
  batch.rewards = absl::MakeSpan(rewards);
  EXPECT_TRUE(pool->Step({.count = kEnvCount, .actions = AllTake(kNoAction)}, batch).ok());
  EXPECT_THAT(rewards, Each(0));
  EXPECT_TRUE(pool->Step({.count = kEnvCount, .actions = AllTake(kNoAction)}, {}).ok());
  EXPECT_THAT(Observed(*pool).episode_lengths, Each(2));
}

TEST(PoolStepTest, FinalObservationsAreWrittenOnlyForEndedEpisodes) {
  const auto pool = MazePool();
  const BatchBuffers before = Observed(*pool);
  BatchBuffers buffers(kEnvCount);
  buffers.final_observations.assign(buffers.final_observations.size(), 7);
  const std::vector<int32_t> actions = {kNoAction, kEndEpisodeAction, kNoAction, kNoAction};
  EXPECT_TRUE(pool->Step({.count = kEnvCount, .actions = actions}, buffers.Whole()).ok());
  const auto row = [](const std::vector<uint8_t>& pixels, size_t i) {
    return RowOf(pixels, kObservationBytes, i);
  };
  EXPECT_THAT(row(buffers.final_observations, 0), Each(7));
  EXPECT_EQ(row(buffers.final_observations, 1), row(before.observations, 1))
      << "the frame of a mouse at rest is unchanged";
  EXPECT_NE(row(buffers.observations, 1), row(before.observations, 1)) << "the new level";
  EXPECT_THAT(row(buffers.final_observations, 2), Each(7));
}

TEST(PoolStepTest, ResetsAndNextLevelsAffectOnlyTheirEnvironments) {
  const auto pool = MazePool();
  const BatchBuffers before = Observed(*pool);
  BatchBuffers buffers(kEnvCount);
  const std::vector<int32_t> actions = {kEndEpisodeAction, kNoAction, kEndEpisodeAction, kNoAction};
  const std::vector<NextLevel> next_levels = {{.environment = 2, .level_seed = 22}};
  const std::vector<Reset> resets = {
      {.environment = 1, .level_seed = 11, .rand_seed = std::nullopt}};
  EXPECT_TRUE(pool->Step({.count = kEnvCount,
                          .actions = actions,
                          .next_levels = next_levels,
                          .resets = resets},
                         buffers.Whole())
                  .ok());
  EXPECT_THAT(buffers.first, ElementsAre(1, 1, 1, 0));
  EXPECT_THAT(buffers.terminated, ElementsAre(1, 0, 1, 0));
  EXPECT_NE(buffers.level_seeds[0], before.level_seeds[0]);
  EXPECT_EQ(buffers.level_seeds[1], 11);
  EXPECT_EQ(buffers.level_seeds[2], 22);
  EXPECT_EQ(buffers.level_seeds[3], before.level_seeds[3]);
  EXPECT_THAT(buffers.episode_lengths, ElementsAre(1, 0, 1, 1));
}

TEST(PoolStepTest, WithoutStepsOnlyTheResetsAreExecuted) {
  const auto pool = MazePool();
  Stepped(*pool, AllTake(kNoAction));
  const std::vector<Reset> resets = {
      {.environment = 3, .level_seed = std::nullopt, .rand_seed = 5}};
  BatchBuffers buffers(kEnvCount);
  EXPECT_TRUE(
      pool->Step({.count = kEnvCount, .steps = false, .resets = resets}, buffers.Whole()).ok());
  EXPECT_THAT(buffers.episode_lengths, ElementsAre(1, 1, 1, 0));
  EXPECT_EQ(buffers.level_seeds[3], RandomStream(5).Int(0, std::numeric_limits<int32_t>::max()));
}

// --- One call at a time.

// Occupies the only thread of a worker pool until Open is called.
class Gate : public ParallelJob {
 public:
  void Open() { gate_.Notify(); }
  void WaitUntilDone() { done_.WaitForNotification(); }

 protected:
  void RunItem(int32_t /*item*/, int32_t /*worker*/) override { gate_.WaitForNotification(); }
  void OnDone() override { done_.Notify(); }

 private:
  absl::Notification gate_;
  absl::Notification done_;
};

TEST(PoolBusyTest, ASecondCallIsAbortedAndChangesNothing) {
  auto workers = std::make_shared<WorkerPool>(1);
  auto pool = *Pool::Create(OptionsOf({"maze"}), workers);
  Gate gate;
  workers->Submit(gate, 1);
  BatchBuffers buffers(kEnvCount);
  const std::vector<int32_t> actions = AllTake(kNoAction);
  absl::Notification done;
  pool->StepAsync({.count = kEnvCount, .actions = actions}, buffers.Whole(),
                  [&done](const absl::Status& status) {
                    EXPECT_TRUE(status.ok());
                    done.Notify();
                  });
  BatchBuffers other(kEnvCount);
  const BatchBuffers blank = other;
  std::vector<uint8_t> frame(64 * 64 * 3);
  EXPECT_EQ(pool->Step({.count = kEnvCount, .actions = actions}, other.Whole()).code(),
            absl::StatusCode::kAborted);
  EXPECT_EQ(pool->Observe(0, kEnvCount, other.Whole()).code(), absl::StatusCode::kAborted);
  EXPECT_EQ(pool->Render(0, 64, absl::MakeSpan(frame)).code(), absl::StatusCode::kAborted);
  EXPECT_EQ(pool->SaveStates({0}).status().code(), absl::StatusCode::kAborted);
  EXPECT_EQ(pool->RestoreStates({}).code(), absl::StatusCode::kAborted);
  EXPECT_EQ(pool->CloneStates({}).code(), absl::StatusCode::kAborted);
  absl::Status rejected;
  pool->StepAsync({.count = kEnvCount, .actions = actions}, other.Whole(),
                  [&rejected](const absl::Status& status) { rejected = status; });
  EXPECT_EQ(rejected.message(),
            "another call steps or reads this pool; retry when it has returned");
  EXPECT_TRUE(other == blank);
  gate.Open();
  done.WaitForNotification();
  gate.WaitUntilDone();
  EXPECT_THAT(Observed(*pool).episode_lengths, Each(1));
}

TEST(PoolBusyTest, ConcurrentCallsAreDoneCompletelyOrNotAtAll) {
  auto workers = std::make_shared<WorkerPool>(2);
  auto pool = *Pool::Create(OptionsOf({"maze", "miner"}), workers);
  std::atomic<int> done_count = 0;
  std::vector<std::thread> threads;
  threads.reserve(4);
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&pool, &done_count] {
      BatchBuffers buffers(kEnvCount);
      const std::vector<int32_t> actions = AllTake(kNoAction);
      for (int i = 0; i < 50; ++i) {
        const absl::Status status =
            pool->Step({.count = kEnvCount, .actions = actions}, buffers.Whole());
        done_count += status.ok() ? 1 : 0;
        EXPECT_TRUE(status.ok() || absl::IsAborted(status));
      }
    });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  EXPECT_GE(done_count, 50);
  EXPECT_THAT(Observed(*pool).episode_lengths, Each(done_count.load()));
}

TEST(PoolStepAsyncTest, GivesTheResultsOfStep) {
  const auto async = MadePool(OptionsOf({"maze", "miner"}), 2);
  const auto sync = MadePool(OptionsOf({"maze", "miner"}));
  for (int i = 0; i < 20; ++i) {
    const std::vector<int32_t> actions = {i % 9, 7, 5, kEndEpisodeAction};
    BatchBuffers buffers(kEnvCount);
    absl::Notification done;
    async->StepAsync({.count = kEnvCount, .actions = actions}, buffers.Whole(),
                     [&done](const absl::Status& /*status*/) { done.Notify(); });
    done.WaitForNotification();
    ASSERT_TRUE(buffers == Stepped(*sync, actions)) << "step " << i;
  }
}

TEST(PoolStepAsyncTest, TheCallbackMayStepThePoolAgain) {
  constexpr int kStepCount = 200;
  const auto pool = MadePool(OptionsOf({"maze"}), 2);
  BatchBuffers buffers(kEnvCount);
  const std::vector<int32_t> actions = AllTake(kNoAction);
  absl::Notification all_done;
  int steps = 0;
  std::function<void()> step = [&] {
    pool->StepAsync({.count = kEnvCount, .actions = actions}, buffers.Whole(),
                    [&](const absl::Status& status) {
                      EXPECT_TRUE(status.ok());
                      if (++steps == kStepCount) {
                        all_done.Notify();
                      } else {
                        step();
                      }
                    });
  };
  step();
  all_done.WaitForNotification();
  EXPECT_THAT(buffers.episode_lengths, Each(kStepCount));
}

TEST(PoolStepAsyncTest, OneEnvironmentIsSteppedBeforeItReturns) {
  const auto async = MadePool(OptionsOf({"maze", "miner"}), 2);
  const auto sync = MadePool(OptionsOf({"maze", "miner"}));
  const std::vector<int32_t> actions = AllTake(7);
  for (int32_t i = 0; i < kEnvCount; ++i) {
    const StepInput input = {.first = i, .count = 1, .actions = absl::MakeSpan(actions).first(1)};
    BatchBuffers stepped(1);
    BatchBuffers expected(1);
    bool done = false;
    async->StepAsync(input, stepped.Whole(), [&done](const absl::Status& status) {
      EXPECT_TRUE(status.ok());
      done = true;
    });
    ASSERT_TRUE(done);
    ASSERT_TRUE(sync->Step(input, expected.Whole()).ok());
    EXPECT_TRUE(stepped == expected) << "environment " << i;
  }
}

TEST(PoolStepAsyncTest, TheCallbackMayDestroyThePool) {
  auto workers = std::make_shared<WorkerPool>(1);
  for (const int32_t count : {1, kEnvCount}) {
    auto pool = *Pool::Create(OptionsOf({"maze"}), workers);
    BatchBuffers buffers(count);
    const std::vector<int32_t> actions(static_cast<size_t>(count), kNoAction);
    absl::Notification done;
    pool->StepAsync({.count = count, .actions = actions}, buffers.Whole(),
                    [&](const absl::Status& /*status*/) {
                      pool.reset();
                      done.Notify();
                    });
    done.WaitForNotification();
    EXPECT_EQ(pool, nullptr);
  }
}

TEST(PoolStepAsyncTest, PoolsOfOneWorkerPoolStepConcurrently) {
  auto workers = std::make_shared<WorkerPool>(2);
  std::vector<std::unique_ptr<Pool>> pools;
  std::vector<std::thread> threads;
  pools.reserve(4);
  threads.reserve(4);
  for (int i = 0; i < 4; ++i) {
    pools.push_back(*Pool::Create(OptionsOf({"miner"}), workers));
  }
  for (const std::unique_ptr<Pool>& pool : pools) {
    threads.emplace_back([&pool] {
      for (int i = 0; i < 50; ++i) {
        Stepped(*pool, {7, 1, 5, 3});
      }
    });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  for (const std::unique_ptr<Pool>& pool : pools) {
    EXPECT_TRUE(Observed(*pool) == Observed(*pools[0]));
  }
}

// --- The human view.

TEST(PoolRenderTest, DrawsAtAllAllowedSizes) {
  const auto pool = MazePool();
  const BatchBuffers before = Observed(*pool);
  for (const int32_t size_px : {kHumanViewSizePxMin, 100, 512}) {
    std::vector<uint8_t> frame(static_cast<size_t>(size_px) * static_cast<size_t>(size_px) * 3);
    EXPECT_TRUE(pool->Render(1, size_px, absl::MakeSpan(frame)).ok()) << size_px;
    EXPECT_GT(std::set<uint8_t>(frame.begin(), frame.end()).size(), 2U)
        << "the frame is not uniform";
  }
  EXPECT_TRUE(Observed(*pool) == before);
}

TEST(PoolRenderTest, RejectsArgumentsOutOfRange) {
  const auto pool = MazePool();
  std::vector<uint8_t> frame(64 * 64 * 3);
  const auto message = [&](int32_t environment, int32_t size_px) {
    const absl::Status status = pool->Render(environment, size_px, absl::MakeSpan(frame));
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    return std::string(status.message());
  };
  EXPECT_EQ(message(-1, 64), "environment -1 is not in [0, 4)");
  EXPECT_EQ(message(4, 64), "environment 4 is not in [0, 4)");
  EXPECT_EQ(message(0, 15), "size_px is 15, must be in [16, 2048]");
  EXPECT_EQ(message(0, 2049), "size_px is 2049, must be in [16, 2048]");
  EXPECT_EQ(message(0, 65), "frame has 12288 bytes, must have 12675");
}

}  // namespace
}  // namespace procgen
