// Observations with frame stacks, compared with a model: a pool with the same seeds and single
// frames, and the last frames of each environment.

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "absl/synchronization/notification.h"
#include "envcore/pool/pool.h"
#include "envcore/random/random_stream.h"
#include "gtest/gtest.h"
#include "tests/envcore/pool/batch_buffers.h"
#include "tests/envcore/pool/small_pool.h"

namespace procgen {
namespace {

using Pixels = std::vector<uint8_t>;

ObservationFormat StackOf(int32_t frame_stack) {
  ObservationFormat format;
  format.frame_stack = frame_stack;
  return format;
}

// Computes frame stacks from single frames.
class StackModel {
 public:
  StackModel(const BatchBuffers& observed, size_t depth) : depth_(depth), stacks_(kEnvCount) {
    for (size_t i = 0; i < kEnvCount; ++i) {
      Fill(i, RowOf(observed.observations, kObservationBytes, i));
    }
  }

  void Fill(size_t i, const Pixels& frame) { stacks_[i].assign(depth_, frame); }
  void Push(size_t i, const Pixels& frame) {
    stacks_[i].pop_front();
    stacks_[i].push_back(frame);
  }
  Pixels Shown(size_t i) const {
    Pixels shown;
    for (const Pixels& frame : stacks_[i]) {
      shown.insert(shown.end(), frame.begin(), frame.end());
    }
    return shown;
  }

 private:
  const size_t depth_;
  std::vector<std::deque<Pixels>> stacks_;  // [N]
};

class PoolStackTest : public testing::TestWithParam<std::tuple<std::string, AutoresetMode>> {
 protected:
  static constexpr int32_t kDepth = 4;
  static constexpr size_t kBytes = size_t{kDepth} * kObservationBytes;

  PoolStackTest()
      : single_(FormattedPool(Game(), {}, std::get<1>(GetParam()))),
        stacked_(FormattedPool(Game(), StackOf(kDepth), std::get<1>(GetParam()))),
        model_(Observed(*single_), kDepth) {}

  static std::string Game() { return std::get<0>(GetParam()); }
  static AutoresetMode Mode() { return std::get<1>(GetParam()); }

  // Steps both pools and compares. Some steps end episodes, reset environments, repeat actions or
  // request no observations.
  void StepAndCompare(int step) {
    StepInput input = {.count = kEnvCount, .actions = actions_};
    std::vector<Reset> resets;
    for (int32_t i = 0; i < kEnvCount; ++i) {
      const bool ends = random_.Int(9) == 0;
      actions_[static_cast<size_t>(i)] = ends ? kEndEpisodeAction : random_.Int(kActionCount);
      if (single_->AwaitsReset(i) || random_.Int(11) == 0) {
        resets.push_back({.environment = i, .level_seed = std::nullopt, .rand_seed = std::nullopt});
      }
    }
    input.resets = resets;
    input.repeat = step % 3 == 2 ? 4 : 1;
    BatchBuffers expected(kEnvCount);
    ASSERT_TRUE(single_->Step(input, expected.Whole()).ok());
    BatchBuffers answered(kEnvCount, kBytes);
    Batch batch = answered.Whole();
    const bool looks = step % 5 != 4;
    if (!looks) {
      batch.observations = {};
      batch.final_observations = {};
    }
    StepInSlices(input, resets, batch, step);
    Compare(expected, answered, looks);
  }

 private:
  // In one slice or two, synchronously or asynchronously.
  void StepInSlices(const StepInput& whole, const std::vector<Reset>& resets, const Batch& batch,
                    int step) {
    if (step % 2 == 0) {
      ASSERT_TRUE(stacked_->Step(whole, batch).ok());
      return;
    }
    for (const int32_t first : {2, 0}) {
      StepInput half = whole;
      half.first = first;
      half.count = 2;
      half.actions = whole.actions.subspan(static_cast<size_t>(first), 2);
      std::vector<Reset> half_resets;
      for (const Reset& reset : resets) {
        if (reset.environment / 2 == first / 2) {
          half_resets.push_back(reset);
        }
      }
      half.resets = half_resets;
      const auto rows = [first](auto span, size_t width) {
        return span.empty() ? span : span.subspan(static_cast<size_t>(first) * width, 2 * width);
      };
      Batch part;
      part.first = rows(batch.first, 1);
      part.observations = rows(batch.observations, kBytes);
      part.final_observations = rows(batch.final_observations, kBytes);
      ASSERT_TRUE(stacked_->Step(half, part).ok());
    }
  }

  void Compare(const BatchBuffers& expected, const BatchBuffers& answered, bool looks) {
    ASSERT_EQ(answered.first, expected.first);
    for (size_t i = 0; i < kEnvCount; ++i) {
      if (Mode() == AutoresetMode::kSameStep &&
          (expected.terminated[i] | expected.truncated[i]) != 0) {
        model_.Push(i, RowOf(expected.final_observations, kObservationBytes, i));
        if (looks) {
          ASSERT_EQ(RowOf(answered.final_observations, kBytes, i), model_.Shown(i)) << i;
        }
      }
      const Pixels frame = RowOf(expected.observations, kObservationBytes, i);
      if (expected.first[i] != 0) {
        model_.Fill(i, frame);
      } else {
        model_.Push(i, frame);
      }
      if (looks) {
        ASSERT_EQ(RowOf(answered.observations, kBytes, i), model_.Shown(i)) << i;
      }
    }
  }

 protected:
  const std::unique_ptr<Pool> single_;
  const std::unique_ptr<Pool> stacked_;
  StackModel model_;
  RandomStream random_{77};
  std::vector<int32_t> actions_ = AllTake(kNoAction);
};

TEST_P(PoolStackTest, ObservationsAreTheLastFramesOfTheEpisode) {
  for (int step = 0; step < 60; ++step) {
    StepAndCompare(step);
    if (HasFatalFailure()) {
      FAIL() << "step " << step;
    }
  }
}

TEST_P(PoolStackTest, ObservingChangesNothing) {
  for (int step = 0; step < 20; ++step) {
    const BatchBuffers once = Observed(*stacked_);
    ASSERT_EQ(Observed(*stacked_), once);
    ASSERT_EQ(RowOf(once.observations, kBytes, 0), model_.Shown(0));
    StepAndCompare(step);
  }
}

INSTANTIATE_TEST_SUITE_P(Ends, PoolStackTest,
                         testing::Combine(testing::Values("maze", "bigfish", "fruitbot"),
                                          testing::Values(AutoresetMode::kSameStep,
                                                          AutoresetMode::kNextStep,
                                                          AutoresetMode::kDisabled)),
                         [](const auto& info) {
                           return std::get<0>(info.param) +
                                  std::to_string(static_cast<int>(std::get<1>(info.param)));
                         });

TEST(PoolStackStateTest, ARestoredEnvironmentShowsItsFrameInAllPlaces) {
  const auto pool = FormattedPool("bigfish", StackOf(3));
  for (int step = 0; step < 8; ++step) {
    Stepped(*pool, AllTake(step));
  }
  const auto states = pool->SaveStates({0});
  ASSERT_TRUE(states.ok());
  const BatchBuffers before = Observed(*pool);
  ASSERT_TRUE(
      pool->RestoreStates({StateToRestore{.environment = 0, .snapshot = states->front()}}).ok());
  const size_t bytes = pool->observation_bytes();
  const auto frame = [](const Pixels& row, size_t place) {
    return RowOf(row, kObservationBytes, place);
  };
  const Pixels saved = RowOf(before.observations, bytes, 0);
  ASSERT_NE(frame(saved, 0), frame(saved, 2)) << "the fish moved";
  const Pixels restored = RowOf(Observed(*pool).observations, bytes, 0);
  for (size_t place = 0; place < 3; ++place) {
    EXPECT_EQ(frame(restored, place), frame(saved, 2));
  }
  EXPECT_EQ(RowOf(Observed(*pool).observations, bytes, 1), RowOf(before.observations, bytes, 1))
      << "no other environment changes";
}

TEST(PoolStackStateTest, ObservingARestoredEnvironmentBeforeItStepsChangesNothing) {
  for (const bool looks : {false, true}) {
    const auto pool = FormattedPool("bigfish", StackOf(3));
    Stepped(*pool, AllTake(5));
    const Pixels saved = RowOf(Observed(*pool).observations, pool->observation_bytes(), 0);
    ASSERT_TRUE(
        pool->CloneStates({StateToClone{.source_environment = 0, .target_environment = 1}}).ok());
    if (looks) {
      Observed(*pool);
    }
    const BatchBuffers after = Stepped(*pool, AllTake(5));
    const Pixels clone = RowOf(after.observations, pool->observation_bytes(), 1);
    const Pixels source = RowOf(after.observations, pool->observation_bytes(), 0);
    for (size_t place = 0; place < 2; ++place) {
      EXPECT_EQ(RowOf(clone, kObservationBytes, place), RowOf(saved, kObservationBytes, 2));
    }
    EXPECT_EQ(RowOf(clone, kObservationBytes, 2), RowOf(source, kObservationBytes, 2));
  }
}

}  // namespace
}  // namespace procgen
