// Invalid steps. The message gives the value and what is allowed, and no environment changes.

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "envcore/pool/pool.h"
#include "gtest/gtest.h"
#include "tests/envcore/pool/batch_buffers.h"
#include "tests/envcore/pool/small_pool.h"

namespace procgen {
namespace {

struct BadStep {
  const char* name;
  std::function<void(StepInput* input, Batch* batch)> spoil;
  const char* message;
};

class BadStepTest : public testing::TestWithParam<BadStep> {
 public:
  // The data of the spans of invalid steps.
  static inline const std::vector<int32_t> kThree = {4, 4, 4};
  static inline const std::vector<int32_t> kFifteen = {4, 15, 4, 4};
  static inline const std::vector<int32_t> kMinusTwo = {4, 4, 4, -2};
  static inline const std::vector<NextLevel> kNextOutside = {{.environment = 4, .level_seed = 1}};
  static inline const std::vector<NextLevel> kNextTwice = {{.environment = 2, .level_seed = 1},
                                                           {.environment = 2, .level_seed = 1}};
  static inline const std::vector<Reset> kResetOutside = {
      {.environment = -1, .level_seed = std::nullopt, .rand_seed = std::nullopt}};
  static inline const std::vector<Reset> kResetTwice = {
      {.environment = 0, .level_seed = std::nullopt, .rand_seed = std::nullopt},
      {.environment = 0, .level_seed = std::nullopt, .rand_seed = std::nullopt}};
};

TEST_P(BadStepTest, IsRejectedAndChangesNothing) {
  const auto pool = MazePool();
  const auto untouched = MazePool();
  BatchBuffers buffers(kEnvCount);
  const BatchBuffers blank = buffers;
  const std::vector<int32_t> actions = AllTake(7);
  StepInput input = {.count = kEnvCount, .actions = actions};
  Batch batch = buffers.Whole();
  GetParam().spoil(&input, &batch);
  const absl::Status status = pool->Step(input, batch);
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(status.message(), GetParam().message);
  EXPECT_TRUE(buffers == blank);
  EXPECT_TRUE(Observed(*pool) == Observed(*untouched));
  EXPECT_TRUE(Stepped(*pool, AllTake(kEndEpisodeAction)) ==
              Stepped(*untouched, AllTake(kEndEpisodeAction)));
}

TEST_P(BadStepTest, IsRejectedBeforeStepAsyncReturns) {
  const auto pool = MadePool(OptionsOf({"maze"}), 1);
  BatchBuffers buffers(kEnvCount);
  const std::vector<int32_t> actions = AllTake(7);
  StepInput input = {.count = kEnvCount, .actions = actions};
  Batch batch = buffers.Whole();
  GetParam().spoil(&input, &batch);
  absl::Status status;
  pool->StepAsync(input, batch, [&status](const absl::Status& rejected) { status = rejected; });
  EXPECT_EQ(status.message(), GetParam().message);
}

INSTANTIATE_TEST_SUITE_P(
    Inputs, BadStepTest,
    testing::Values(
        BadStep{"FirstBelowZero", [](StepInput* input, Batch*) { input->first = -1; },
                "the slice is 4 environments from -1, the pool has 4"},
        BadStep{"CountZero", [](StepInput* input, Batch*) { input->count = 0; },
                "the slice is 0 environments from 0, the pool has 4"},
        BadStep{"PastTheEnd", [](StepInput* input, Batch*) { input->first = 1; },
                "the slice is 4 environments from 1, the pool has 4"},
        BadStep{
            "SumTooLarge",
            [](StepInput* input, Batch*) { input->first = std::numeric_limits<int32_t>::max(); },
            "the slice is 4 environments from 2147483647, the pool has 4"},
        BadStep{"TooFewActions",
                [](StepInput* input, Batch*) { input->actions = BadStepTest::kThree; },
                "actions has 3 entries, the slice has 4 environments to step"},
        BadStep{"ActionsWithoutSteps", [](StepInput* input, Batch*) { input->steps = false; },
                "actions has 4 entries, the slice has 0 environments to step"},
        BadStep{"ActionTooLarge",
                [](StepInput* input, Batch*) { input->actions = BadStepTest::kFifteen; },
                "action 15 of environment 1 is not in [-1, 14]"},
        BadStep{"ActionTooSmall",
                [](StepInput* input, Batch*) { input->actions = BadStepTest::kMinusTwo; },
                "action -2 of environment 3 is not in [-1, 14]"},
        BadStep{"RepeatZero", [](StepInput* input, Batch*) { input->repeat = 0; },
                "repeat is 0, must be in [1, 1000]"},
        BadStep{"RepeatTooLarge", [](StepInput* input, Batch*) { input->repeat = 1001; },
                "repeat is 1001, must be in [1, 1000]"},
        BadStep{"NextLevelOutside",
                [](StepInput* input, Batch*) { input->next_levels = BadStepTest::kNextOutside; },
                "next_levels names environment 4, the slice is [0, 4)"},
        BadStep{"NextLevelTwice",
                [](StepInput* input, Batch*) { input->next_levels = BadStepTest::kNextTwice; },
                "next_levels names environment 2 twice"},
        BadStep{"ResetOutside",
                [](StepInput* input, Batch*) { input->resets = BadStepTest::kResetOutside; },
                "resets names environment -1, the slice is [0, 4)"},
        BadStep{"ResetTwice",
                [](StepInput* input, Batch*) { input->resets = BadStepTest::kResetTwice; },
                "resets names environment 0 twice"},
        BadStep{"ObservationsTooShort",
                [](StepInput*, Batch* batch) { batch->observations.remove_suffix(1); },
                "the batch's observations have 49151 values, must have 49152 or none"},
        BadStep{"RewardsTooShort",
                [](StepInput*, Batch* batch) { batch->rewards.remove_suffix(1); },
                "the batch's rewards have 3 values, must have 4 or none"},
        BadStep{"FinalObservationsTooShort",
                [](StepInput*, Batch* batch) { batch->final_observations.remove_suffix(1); },
                "the batch's final_observations have 49151 values, must have 49152 or none"}),
    [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace procgen
