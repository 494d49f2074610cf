// Slices, requests sent ahead, resets, next levels and samplers.

#include <cstdint>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/clients/c/c_pool.h"

namespace procgen {
namespace {

using testing::Each;
using testing::HasSubstr;

class RequestTest : public testing::TestWithParam<int32_t> {
 protected:
  CPool Pool(const char* game = "maze") {
    COptions options(game);
    options.num_threads = GetParam();
    return Made(options);
  }
};

TEST_P(RequestTest, HalvesSentAheadEqualWholeSteps) {
  const CPool whole = Pool("bigfish");
  const CPool halves = Pool("bigfish");
  const std::vector<BatchBuffers> expected = Steps(whole.get(), 4, 0, 20);
  for (int32_t t = 0; t < 20; ++t) {
    const std::vector<int32_t> actions = ActionsAt(t, 4);
    BatchBuffers buffers(4);
    for (const int32_t first : {0, 2}) {
      const std::vector<int32_t> half(actions.begin() + first, actions.begin() + first + 2);
      const ProcgenStep step = StepOf(half, first);
      const ProcgenBatch batch = BatchIn(buffers, first);
      ASSERT_EQ(procgen_send_step(halves.get(), &step, &batch), PROCGEN_OK);
    }
    EXPECT_EQ(procgen_unanswered_count(halves.get()), 2);
    ASSERT_EQ(procgen_receive(halves.get(), -1), PROCGEN_OK);
    ASSERT_EQ(procgen_receive(halves.get(), -1), PROCGEN_OK);
    ASSERT_EQ(buffers, expected[static_cast<size_t>(t)]);
  }
}

TEST_P(RequestTest, AnErrorAnswersItsOwnRequestOnly) {
  COptions options("maze");
  options.autoreset_mode = PROCGEN_DISABLED;
  options.num_threads = GetParam();
  const CPool pool = Made(options);
  BatchBuffers buffers(4);
  const ProcgenBatch batch = BatchIn(buffers);
  const std::vector<int32_t> ends(4, -1);
  const ProcgenStep step = StepOf(ends);
  for (int i = 0; i < 2; ++i) {
    ASSERT_EQ(procgen_send_step(pool.get(), &step, &batch), PROCGEN_OK);
  }
  ASSERT_EQ(procgen_send_observe(pool.get(), 0, 4, &batch), PROCGEN_OK);
  EXPECT_EQ(procgen_receive(pool.get(), -1), PROCGEN_OK);
  EXPECT_EQ(procgen_receive(pool.get(), -1), PROCGEN_FAILED_PRECONDITION);
  EXPECT_THAT(procgen_error_message(), HasSubstr("reset it before it is stepped"));
  EXPECT_EQ(procgen_receive(pool.get(), -1), PROCGEN_OK);
  EXPECT_THAT(buffers.terminated, Each(1));
}

TEST_P(RequestTest, OnlyAnIdlePoolIsSteppedSavedOrDrawn) {
  const CPool pool = Pool();
  BatchBuffers buffers(4);
  const ProcgenBatch batch = BatchIn(buffers);
  ASSERT_EQ(procgen_send_observe(pool.get(), 0, 4, &batch), PROCGEN_OK);
  EXPECT_EQ(procgen_observe(pool.get(), 0, 4, &batch), PROCGEN_FAILED_PRECONDITION);
  EXPECT_THAT(procgen_error_message(), HasSubstr("1 requests are unanswered"));
  std::vector<uint8_t> frame(64 * 64 * 3);
  EXPECT_EQ(procgen_render(pool.get(), 0, 64, 0, frame.data()), PROCGEN_FAILED_PRECONDITION);
  EXPECT_EQ(procgen_receive(pool.get(), 10), PROCGEN_OK);
  EXPECT_EQ(procgen_render(pool.get(), 0, 64, 0, frame.data()), PROCGEN_OK);
  EXPECT_EQ(procgen_receive(pool.get(), -1), PROCGEN_FAILED_PRECONDITION);
}

TEST_P(RequestTest, APoolMayBeDestroyedWithUnansweredRequests) {
  CPool pool = Pool();
  BatchBuffers buffers(4);
  const ProcgenBatch batch = BatchIn(buffers);
  const std::vector<int32_t> actions(4, 4);
  ProcgenStep step = StepOf(actions);
  step.repeat_count = 1000;
  for (int i = 0; i < 5; ++i) {
    ASSERT_EQ(procgen_send_step(pool.get(), &step, &batch), PROCGEN_OK);
  }
  pool = nullptr;
}

TEST_P(RequestTest, ResetsNextLevelsAndSamplersChooseLevels) {
  const CPool pool = Pool();
  BatchBuffers buffers(4);
  const ProcgenBatch batch = BatchIn(buffers);
  const ProcgenReset reset = {
      .environment = 1, .level_seed = 42, .rand_seed = 0, .has_level_seed = 1, .has_rand_seed = 0};
  ASSERT_EQ(procgen_reset(pool.get(), 0, 4, &reset, 1, &batch), PROCGEN_OK);
  EXPECT_EQ(buffers.level_seeds[1], 42);

  const ProcgenNextLevel next = {.environment = 2, .level_seed = 43};
  const std::vector<int32_t> ends(4, -1);
  ProcgenStep step = StepOf(ends);
  step.next_levels = &next;
  step.next_level_count = 1;
  ASSERT_EQ(procgen_step(pool.get(), &step, &batch), PROCGEN_OK);
  EXPECT_EQ(buffers.level_seeds[2], 43);
  EXPECT_EQ(buffers.prev_level_seeds[1], 42);

  const std::vector<int32_t> seeds = {100, 101};
  const ProcgenLevelSampler sampler = {.struct_size = sizeof(sampler),
                                       .level_seeds = seeds.data(),
                                       .weights = nullptr,
                                       .seed_count = 2,
                                       .rand_seed = 1};
  ASSERT_EQ(procgen_set_level_sampler(pool.get(), &sampler), PROCGEN_OK);
  step = StepOf(ends);
  ASSERT_EQ(procgen_step(pool.get(), &step, &batch), PROCGEN_OK);
  EXPECT_THAT(buffers.level_seeds, Each(testing::AnyOf(100, 101)));
}

INSTANTIATE_TEST_SUITE_P(Threads, RequestTest, testing::Values(0, 2),
                         [](const auto& info) { return "Threads" + std::to_string(info.param); });

}  // namespace
}  // namespace procgen
