#include "server/fleet/log/frame_stack_warmup.h"

#include "gtest/gtest.h"

namespace procgen {
namespace {

LoggedRequest StepOf(Part slice) {
  LoggedRequest logged;
  logged.request.mutable_step()->mutable_slice()->set_first_env(slice.first);
  logged.request.mutable_step()->mutable_slice()->set_env_count(slice.count);
  return logged;
}

TEST(FrameStackWarmupTest, SingleFramesNeedNoSteps) {
  FrameStackWarmup warmup(4, 1);
  warmup.Add(1, StepOf({0, 4}));
  EXPECT_TRUE(warmup.IsComplete({0, 4}, 1));
  warmup.Forget();
  EXPECT_TRUE(warmup.IsComplete({0, 4}, 1));
}

TEST(FrameStackWarmupTest, WarmupStepsEachEnvironmentStackDepthMinusOneTimes) {
  FrameStackWarmup warmup(8, 3);
  warmup.Add(1, StepOf({0, 8}));
  EXPECT_FALSE(warmup.IsComplete({2, 2}, 1));
  warmup.Add(2, StepOf({0, 8}));
  warmup.Add(3, StepOf({0, 3}));  // only the first environment of the range
  EXPECT_FALSE(warmup.IsComplete({2, 2}, 1));
  warmup.Add(4, StepOf({4, 4}));  // none of the range
  EXPECT_FALSE(warmup.IsComplete({2, 2}, 1));
  warmup.Add(5, StepOf({3, 1}));
  EXPECT_TRUE(warmup.IsComplete({2, 2}, 1));
  EXPECT_FALSE(warmup.IsComplete({2, 2}, 2)) << "states from a later step";
}

TEST(FrameStackWarmupTest, UnsteppedEnvironmentNeedsNoSteps) {
  FrameStackWarmup warmup(2, 4);
  for (int64_t number = 1; number < 9; ++number) {
    warmup.Add(number, StepOf({1, 1}));
  }
  EXPECT_TRUE(warmup.IsComplete({0, 2}, 5)) << "the other was stepped three times since";
  EXPECT_FALSE(warmup.IsComplete({0, 2}, 6));
}

TEST(FrameStackWarmupTest, NewEpisodeNeedsNoSteps) {
  FrameStackWarmup warmup(3, 4);
  warmup.Add(1, StepOf({0, 3}));
  LoggedRequest reset;
  reset.request.mutable_reset()->add_resets()->set_environment(0);
  warmup.Add(2, reset);
  LoggedRequest step = StepOf({1, 1});
  step.request.mutable_step()->add_resets()->set_environment(1);
  warmup.Add(3, step);
  LoggedRequest states;
  states.states.emplace_back().set_environment(2);
  warmup.Add(4, states);
  EXPECT_TRUE(warmup.IsComplete({0, 3}, 1));
  EXPECT_TRUE(warmup.IsComplete({0, 3}, 4));
  warmup.Add(5, StepOf({0, 3}));
  EXPECT_TRUE(warmup.IsComplete({0, 3}, 4));
  EXPECT_FALSE(warmup.IsComplete({0, 1}, 5));
}

TEST(FrameStackWarmupTest, UnknownEnvironmentsNeedSteps) {
  FrameStackWarmup warmup(1, 2);
  warmup.Forget();
  EXPECT_FALSE(warmup.IsComplete({0, 1}, 7));
  warmup.Add(8, StepOf({0, 1}));
  EXPECT_TRUE(warmup.IsComplete({0, 1}, 7));
}

}  // namespace
}  // namespace procgen
