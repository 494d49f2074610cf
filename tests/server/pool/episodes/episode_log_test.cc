#include "server/pool/episodes/episode_log.h"

#include <algorithm>
#include <string>
#include <vector>

#include "absl/types/span.h"
#include "envcore/pool/batch_numbers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;

constexpr int64_t kPlenty = int64_t{1} << 30;

// A fake pool. An episode continues unless a step ends it.
class FakePool {
 public:
  FakePool(int32_t env_count, EpisodeLog* log) : env_count_(env_count), log_(log) {}

  // Steps all environments; `ends`: environments whose episode ends.
  void Step(int32_t action, const std::vector<int32_t>& ends = {}, float reward = 0) {
    StepSlice(0, env_count_, action, ends, reward);
  }

  // Steps a slice; `completes`: all its environments complete a level within their episode.
  void StepSlice(int32_t first, int32_t count, int32_t action,
                 const std::vector<int32_t>& ends = {}, float reward = 0, bool completes = false,
                 absl::Span<const Annotation> annotations = {}) {
    const std::vector<int32_t> actions(static_cast<size_t>(count), action);
    const Batch batch = memory_.ReplaceEmptyArrays({}, count);
    for (size_t row = 0; row < actions.size(); ++row) {
      const bool ended =
          std::count(ends.begin(), ends.end(), first + static_cast<int32_t>(row)) != 0;
      batch.rewards[row] = reward;
      batch.terminated[row] = ended ? 1 : 0;
      batch.truncated[row] = 0;
      batch.first[row] = ended ? 1 : 0;
      batch.prev_level_complete[row] = completes ? 1 : 0;
      batch.prev_level_seeds[row] = level_;
      batch.level_seeds[row] = ended ? level_ + 1 : level_;
      batch.episode_lengths[row] = 1;
      batch.episode_returns[row] = reward;
      batch.fingerprints[row] = 99;
    }
    log_->Add({.first = first, .count = count, .actions = actions}, batch,
              {annotations, first, count});
    level_ += ends.empty() ? 0 : 1;
  }

 private:
  const int32_t env_count_;
  EpisodeLog* const log_;
  BatchNumbers memory_;
  int32_t level_ = 30;
};

Episode EpisodeOf(const EpisodeLog* log, int32_t environment, bool under_way) {
  const auto recording = log->Read(environment, under_way);
  EXPECT_THAT(recording, IsOk());
  return recording.ok() ? recording->Decode() : Episode();
}

TEST(EpisodeLogTest, ReturnsActionsRewardsAndTheEnd) {
  ByteBudget bytes(kPlenty);
  EpisodeLog log(2, &bytes);
  FakePool pool(2, &log);
  pool.Step(7, {}, 0.5F);
  pool.Step(-1, {1}, -1);
  pool.Step(3);
  const Episode last = EpisodeOf(&log, 1, false);
  EXPECT_EQ(last.level_seed, 30);
  EXPECT_EQ(last.actions, std::string("\x07\xff"));
  EXPECT_THAT(last.rewards, ElementsAre(0.5F, -1));
  EXPECT_THAT(last.action_counts, IsEmpty());
  EXPECT_EQ(last.outcome, EpisodeOutcome::kTerminated);
  EXPECT_EQ(last.fingerprint, 99U);
  EXPECT_EQ(last.incomplete_reason, IncompleteReason::kNone);
  const Episode current = EpisodeOf(&log, 1, true);
  EXPECT_EQ(current.level_seed, 31);
  EXPECT_EQ(current.actions, std::string("\x03"));
  EXPECT_EQ(EpisodeOf(&log, 0, true).actions, std::string("\x07\xff\x03"));
  EXPECT_THAT(log.Read(0, false), StatusIs(absl::StatusCode::kFailedPrecondition,
                                           HasSubstr("environment 0 has ended no episode yet")));
}

TEST(EpisodeLogTest, ReturnedEpisodesDoNotChange) {
  ByteBudget bytes(kPlenty);
  EpisodeLog log(1, &bytes);
  FakePool pool(1, &log);
  pool.Step(7);
  const auto recording = log.Read(0, true);
  ASSERT_THAT(recording, IsOk());
  pool.Step(8);
  EXPECT_EQ(recording->Decode().actions, std::string("\x07"));
  EXPECT_EQ(EpisodeOf(&log, 0, true).actions, std::string("\x07\x08"));
}

TEST(EpisodeLogTest, UnneededStepsAreDropped) {
  ByteBudget bytes(kPlenty);
  EpisodeLog log(100, &bytes);
  FakePool pool(100, &log);
  std::vector<int32_t> all(100);
  for (int32_t i = 0; i < 100; ++i) {
    all[static_cast<size_t>(i)] = i;
  }
  for (int32_t episode = 0; episode < 500; ++episode) {
    for (int32_t step = 0; step < 99; ++step) {
      pool.Step(step % 15);
    }
    pool.Step(-1, all);
  }
  // Two buffers of 128 bytes per environment.
  EXPECT_EQ(bytes.reserved_bytes(), 100 * 2 * 128);
  EXPECT_THAT(EpisodeOf(&log, 50, false).actions, SizeIs(100));
  EXPECT_EQ(EpisodeOf(&log, 50, false).incomplete_reason, IncompleteReason::kNone);
}

TEST(EpisodeLogTest, FullLogDropsTheOldestStepsAndReportsIt) {
  ByteBudget bytes(300'000);
  EpisodeLog log(1000, &bytes);
  FakePool pool(1000, &log);
  pool.Step(1);
  pool.Step(-1, {7});
  for (int32_t step = 0; step < 2000; ++step) {
    pool.Step(step % 15);
    ASSERT_LE(bytes.reserved_bytes(), 300'000);
  }
  EXPECT_EQ(EpisodeOf(&log, 7, false).incomplete_reason, IncompleteReason::kTooOld);
  const Episode current = EpisodeOf(&log, 8, true);
  EXPECT_EQ(current.incomplete_reason, IncompleteReason::kTooOld);
  EXPECT_GT(current.actions.size(), 100U);
  EXPECT_EQ(current.actions.back(), static_cast<char>(1999 % 15));
  pool.Step(-1, {8});
  pool.Step(2);
  EXPECT_EQ(EpisodeOf(&log, 8, true).incomplete_reason, IncompleteReason::kNone);
  EXPECT_EQ(EpisodeOf(&log, 8, true).actions, std::string("\x02"));
}

TEST(EpisodeLogTest, AlternatingSlicesKeepTheLatestStepInSmallMemory) {
  ByteBudget bytes(200'000);
  EpisodeLog log(64, &bytes);
  FakePool pool(64, &log);
  int32_t checked = 0;
  for (int32_t step = 0; step < 6000; ++step) {
    const int32_t first = step % 2 * 32;
    const int64_t before = bytes.reserved_bytes();
    pool.StepSlice(first, 32, step % 15, {}, /*reward=*/1, /*completes=*/true);
    ASSERT_LE(bytes.reserved_bytes(), 200'000);
    if (bytes.reserved_bytes() >= before && step % 500 != 0) {
      continue;
    }
    ++checked;  // after freed memory, and every 500 steps
    const Episode episode = EpisodeOf(&log, first, true);
    ASSERT_THAT(episode.actions, Not(IsEmpty())) << "step " << step;
    EXPECT_EQ(episode.actions.back(), static_cast<char>(step % 15));
    ASSERT_THAT(episode.level_changes, Not(IsEmpty()));
    EXPECT_EQ(episode.level_changes.back().action,
              static_cast<int32_t>(episode.actions.size()) - 1);
  }
  EXPECT_GE(checked, 12);
}

TEST(EpisodeLogTest, AnnotationsBelongToTheStepsOfTheirEpisode) {
  ByteBudget bytes(kPlenty);
  {
    EpisodeLog log(2, &bytes);
    FakePool pool(2, &log);
    const auto step = [&pool](float value, const std::vector<int32_t>& ends = {}) {
      const std::vector<float> values = {value, -value};
      pool.StepSlice(0, 2, 4, ends, 0, false, {{"value", values}});
    };
    pool.Step(4);
    step(1);
    step(2, {1});
    step(3);
    const Episode current = EpisodeOf(&log, 0, true);
    ASSERT_THAT(current.annotations, SizeIs(1));
    EXPECT_EQ(current.annotations[0].name, "value");
    EXPECT_EQ(current.annotations[0].first_step, 1);
    EXPECT_THAT(current.annotations[0].values, ElementsAre(1, 2, 3));
    EXPECT_THAT(EpisodeOf(&log, 1, false).annotations[0].values, ElementsAre(-1, -2));
    EXPECT_THAT(EpisodeOf(&log, 1, true).annotations[0].values, ElementsAre(-3));
    EXPECT_EQ(EpisodeOf(&log, 1, true).annotations[0].first_step, 0);
  }
  EXPECT_EQ(bytes.reserved_bytes(), 0);
}

TEST(EpisodeLogTest, SaliencyIsRecordedInBlocksOfFourByFourPixels) {
  ByteBudget bytes(kPlenty);
  EpisodeLog log(2, &bytes);
  FakePool pool(2, &log);
  std::vector<float> maps(2 * 64 * 64);
  maps[64 * 64 + 5] = 8;        // of environment 1: the first row of blocks, the second block
  maps[64 * 64 + 64 + 6] = 16;  // the same block
  maps[2 * 64 * 64 - 1] = -4;   // the last block
  const std::vector<float> middle(2 * 32 * 32, 1);
  pool.StepSlice(0, 2, 4, {}, 0, false, {{"saliency", maps}});
  const Episode episode = EpisodeOf(&log, 1, true);
  ASSERT_THAT(episode.annotations, SizeIs(1));
  std::vector<float> expected(16 * 16);
  expected[1] = 1.5;
  expected[255] = -0.25;
  EXPECT_EQ(episode.annotations[0].value_count, 256);
  EXPECT_EQ(episode.annotations[0].values, expected);
  pool.StepSlice(0, 2, 4, {1}, 0, false, {});
  pool.StepSlice(0, 2, 4, {}, 0, false, {{"saliency", middle}});
  EXPECT_THAT(EpisodeOf(&log, 1, true).annotations, SizeIs(0)) << "1,024 values are too many";
}

TEST(EpisodeLogTest, AnnotationsAreDroppedBeforeSteps) {
  constexpr int64_t kBytes = 200'000;
  ByteBudget bytes(kBytes);
  EpisodeLog log(4, &bytes);
  FakePool pool(4, &log);
  const std::vector<float> values(4 * 16, 1);
  for (int32_t step = 0; step < 8000; ++step) {
    const std::vector<int32_t> ends(step % 3000 == 2999 ? 1 : 0, 2);
    pool.StepSlice(0, 4, step % 15, ends, 0, false, {{"probabilities", values}});
    ASSERT_LE(bytes.reserved_bytes(), kBytes);
    if (step % 100 == 0) {
      const Episode current = EpisodeOf(&log, 2, true);
      for (const AnnotationSeries& series : current.annotations) {
        const size_t rows = series.values.size() / 16;
        ASSERT_EQ(static_cast<size_t>(series.first_step) + rows, current.rewards.size());
      }
    }
  }
  // Half of the budget holds the newest annotations; all steps are there.
  EXPECT_EQ(EpisodeOf(&log, 2, false).incomplete_reason, IncompleteReason::kNone);
  EXPECT_THAT(EpisodeOf(&log, 2, false).actions, SizeIs(3000));
  EXPECT_THAT(EpisodeOf(&log, 0, true).actions, SizeIs(8000));
  EXPECT_THAT(EpisodeOf(&log, 2, true).annotations, SizeIs(1));
  EXPECT_GT(EpisodeOf(&log, 2, true).annotations[0].first_step, 0);
}

}  // namespace
}  // namespace procgen
