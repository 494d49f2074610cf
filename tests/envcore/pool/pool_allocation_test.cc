// A step allocates nothing once everything was drawn before. Counts all allocations of the process
// while a pool repeats the same steps. Generating a level allocates, so steps with a new level are
// not counted.

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/synchronization/notification.h"
#include "envcore/pool/pool.h"
#include "gtest/gtest.h"
#include "tests/envcore/pool/allocation_count.h"
#include "tests/envcore/pool/batch_buffers.h"

namespace procgen {
namespace {

constexpr int32_t kEnvCount = 8;
constexpr int kStepCount = 250;

class PoolAllocationTest : public testing::TestWithParam<std::string> {
 protected:
  explicit PoolAllocationTest(const ObservationFormat& format = {})
      : format_(format), buffers_(kEnvCount, format.bytes()), actions_(kEnvCount) {}

  // Plays the same steps twice and returns the number of allocations in the second run, except in
  // steps with a new level.
  int64_t AllocationsOfStepsSeenBefore(int32_t thread_count) {
    PoolOptions options;
    options.games = {GetParam()};
    options.env_count = kEnvCount;
    options.observation_format = format_;
    pool_ = *Pool::Create(options, std::make_shared<WorkerPool>(thread_count));
    PlayFromTheStart();
    return PlayFromTheStart();
  }

  virtual void StepOnce() {
    ASSERT_TRUE(pool_->Step({.count = kEnvCount, .actions = actions_}, buffers_.Whole()).ok());
  }

  const ObservationFormat format_;
  std::unique_ptr<Pool> pool_;
  BatchBuffers buffers_;
  std::vector<int32_t> actions_;

 private:
  int64_t PlayFromTheStart() {
    std::vector<Reset> resets;
    resets.reserve(kEnvCount);
    for (int32_t i = 0; i < kEnvCount; ++i) {
      resets.push_back({.environment = i, .level_seed = std::nullopt, .rand_seed = i});
    }
    EXPECT_TRUE(
        pool_->Step({.count = kEnvCount, .steps = false, .resets = resets}, buffers_.Whole()).ok());
    int64_t allocations = 0;
    for (int step = 0; step < kStepCount; ++step) {
      for (size_t i = 0; i < actions_.size(); ++i) {
        actions_[i] = (step / 5 + static_cast<int>(i)) % kActionCount;
      }
      const int64_t before = AllocationCount();
      StepOnce();
      const int64_t count = AllocationCount() - before;
      const bool new_level =
          std::count(buffers_.first.begin(), buffers_.first.end(), 0) != kEnvCount;
      allocations += new_level ? 0 : count;
    }
    return allocations;
  }
};

TEST_P(PoolAllocationTest, AStepAllocatesNothing) { EXPECT_EQ(AllocationsOfStepsSeenBefore(0), 0); }

// The assignment of environments to workers varies. So a worker may enlarge a buffer for a scene
// that it draws for the first time, but not in every step.
constexpr int64_t kRoomMakingMax = kStepCount / 10;

TEST_P(PoolAllocationTest, AStepOnAWorkerPoolAllocatesNothing) {
  EXPECT_LE(AllocationsOfStepsSeenBefore(2), kRoomMakingMax);
}

class PoolStepAsyncAllocationTest : public PoolAllocationTest {
 protected:
  void StepOnce() override {
    absl::Notification done;
    pool_->StepAsync({.count = kEnvCount, .actions = actions_}, buffers_.Whole(),
                     [&done](const absl::Status& /*status*/) { done.Notify(); });
    done.WaitForNotification();
  }
};

TEST_P(PoolStepAsyncAllocationTest, AnAsynchronousStepAllocatesNothing) {
  EXPECT_LE(AllocationsOfStepsSeenBefore(2), kRoomMakingMax);
}

ObservationFormat FourGreyFramesOf84() {
  ObservationFormat format;
  format.frame = {.size_px = 84, .color = Color::kGrayscale};
  format.frame_stack = 4;
  return format;
}

class PoolStackAllocationTest : public PoolAllocationTest {
 protected:
  PoolStackAllocationTest() : PoolAllocationTest(FourGreyFramesOf84()) {}
};

TEST_P(PoolStackAllocationTest, AStepOfStackedFramesAllocatesNothing) {
  EXPECT_EQ(AllocationsOfStepsSeenBefore(0), 0);
}

std::vector<std::string> AllGames() {
  std::vector<std::string> names;
  for (const GameSpec& game : GameCatalog()) {
    names.emplace_back(game.name);
  }
  return names;
}

INSTANTIATE_TEST_SUITE_P(Catalog, PoolAllocationTest, testing::ValuesIn(AllGames()),
                         [](const auto& info) { return info.param; });
INSTANTIATE_TEST_SUITE_P(Catalog, PoolStackAllocationTest, testing::ValuesIn(AllGames()),
                         [](const auto& info) { return info.param; });
INSTANTIATE_TEST_SUITE_P(Catalog, PoolStepAsyncAllocationTest, testing::ValuesIn(AllGames()),
                         [](const auto& info) { return info.param; });

}  // namespace
}  // namespace procgen
