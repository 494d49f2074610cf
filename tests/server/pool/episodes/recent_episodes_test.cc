#include "server/pool/episodes/recent_episodes.h"

#include <optional>

#include "gtest/gtest.h"

namespace procgen {
namespace {

EndedEpisode EpisodeOf(int32_t i) {
  EndedEpisode episode;
  episode.environment = i;
  episode.total_reward = static_cast<float>(i);
  episode.length = 2 * i;
  return episode;
}

TEST(RecentEpisodesTest, StatisticsCoverTheLastHundred) {
  ByteBudget bytes(0);
  RecentEpisodes episodes(&bytes);
  for (int32_t i = 0; i < 150; ++i) {
    episodes.Add(EpisodeOf(i), std::nullopt);
  }
  const RecentEpisodes::Summary summary = episodes.Read();
  EXPECT_EQ(summary.count, 150);
  EXPECT_FLOAT_EQ(summary.mean_return, 99.5);  // of 50 to 149
  EXPECT_FLOAT_EQ(summary.mean_length, 199);
  const RecentEpisodes::ReturnSpread spread = episodes.ReadReturnSpread();
  EXPECT_EQ(spread.min, 50);
  EXPECT_EQ(spread.max, 149);
  EXPECT_NEAR(spread.deviation, 28.866, 0.001);  // sqrt((100^2 - 1) / 12)
}

TEST(RecentEpisodesTest, ListHasTheLastThousandOldestFirst) {
  ByteBudget bytes(0);
  RecentEpisodes episodes(&bytes);
  for (int32_t i = 0; i < 2500; ++i) {
    episodes.Add(EpisodeOf(i), std::nullopt);
  }
  const RecentEpisodes::List all = episodes.ReadList(0);
  EXPECT_EQ(all.count, 2500);
  ASSERT_EQ(all.episodes.size(), 1000U);
  EXPECT_EQ(all.episodes.front().environment, 1500);
  EXPECT_EQ(all.episodes.back().environment, 2499);
  EXPECT_EQ(episodes.Read().mean_return, 2449.5);
}

TEST(RecentEpisodesTest, ListSkipsEpisodesThatTheReaderHas) {
  ByteBudget bytes(0);
  RecentEpisodes episodes(&bytes);
  for (int32_t i = 0; i < 5; ++i) {
    episodes.Add(EpisodeOf(i), std::nullopt);
  }
  const RecentEpisodes::List rest = episodes.ReadList(3);
  EXPECT_EQ(rest.count, 5);
  ASSERT_EQ(rest.episodes.size(), 2U);
  EXPECT_EQ(rest.episodes.front().environment, 3);
  EXPECT_TRUE(episodes.ReadList(5).episodes.empty());
  EXPECT_TRUE(episodes.ReadList(9).episodes.empty());
}

// A recording of `bytes` bytes and `steps` steps.
EpisodeRecording RecordingOf(int64_t bytes, int32_t steps) {
  EpisodeRecording recording;
  recording.Reallocate(bytes);
  for (int32_t i = 0; i < steps; ++i) {
    recording.AddStep(/*action=*/4, /*count=*/1, /*reward=*/0);
  }
  return recording;
}

EndedEpisode EpisodeWith(uint64_t fingerprint) {
  EndedEpisode episode;
  episode.environment = 3;
  episode.fingerprint = fingerprint;
  return episode;
}

TEST(RecentEpisodesTest, RecordingsAreFoundByFingerprint) {
  ByteBudget bytes(1 << 20);
  {
    RecentEpisodes episodes(&bytes);
    for (uint64_t i = 1; i <= 1005; ++i) {
      episodes.Add(EpisodeWith(i), RecordingOf(64, static_cast<int32_t>(i % 40)));
    }
    EXPECT_EQ(episodes.ReadList(0).recorded_count, 1000);
    EXPECT_EQ(episodes.Find(3, 5), std::nullopt) << "no longer in the list";
    ASSERT_NE(episodes.Find(3, 6), std::nullopt);
    EXPECT_EQ(episodes.Find(3, 6)->Decode().actions.size(), 6U);
    EXPECT_EQ(episodes.Find(3, 1005)->Decode().actions.size(), 5U);
    EXPECT_EQ(episodes.Find(4, 6), std::nullopt) << "of another environment";
    EXPECT_GE(bytes.reserved_bytes(), 64'000);
  }
  EXPECT_EQ(bytes.reserved_bytes(), 0);
}

TEST(RecentEpisodesTest, OldestRecordingsAreDroppedForNewOnes) {
  ByteBudget bytes(64 << 20);
  RecentEpisodes episodes(&bytes);
  for (uint64_t i = 1; i <= 10; ++i) {
    episodes.Add(EpisodeWith(i), RecordingOf(1 << 20, 1));
  }
  EXPECT_EQ(episodes.ReadList(0).recorded_count, 3) << "of 1 MiB each, of at most 4 MiB";
  EXPECT_EQ(episodes.ReadList(0).episodes.size(), 10U);
  EXPECT_EQ(episodes.Find(3, 7), std::nullopt);
  EXPECT_NE(episodes.Find(3, 8), std::nullopt);
}

TEST(RecentEpisodesTest, RecordingsTakeHalfOfTheBudget) {
  ByteBudget bytes(20'000);
  RecentEpisodes episodes(&bytes);
  for (uint64_t i = 1; i <= 100; ++i) {
    episodes.Add(EpisodeWith(i), RecordingOf(1000, 1));
  }
  EXPECT_LE(bytes.reserved_bytes(), 10'000);
  EXPECT_GE(episodes.ReadList(0).recorded_count, 7);
  bytes.Change(0, 9'500);  // for something else
  episodes.Add(EpisodeWith(101), RecordingOf(1000, 1));
  EXPECT_EQ(episodes.ReadList(0).recorded_count, 0);
  EXPECT_EQ(episodes.ReadList(0).count, 101);
}

TEST(RecentEpisodesTest, AnnotationsOfTheBestAndTheWorstEpisodeAreDroppedLast) {
  ByteBudget bytes(int64_t{1} << 30);
  RecentEpisodes episodes(&bytes);
  const std::vector<float> values(64, 1);
  for (uint64_t i = 1; i <= 200; ++i) {
    EpisodeRecording recording = RecordingOf(2000, 1000);
    for (int32_t step = 0; step < 1000; ++step) {
      const StepAnnotation annotation = {"x", values};
      recording.annotations.Add(step, absl::MakeConstSpan(&annotation, 1));
    }
    EndedEpisode episode = EpisodeWith(i);
    episode.total_reward = i == 20 ? 30 : i == 30 ? -5 : static_cast<float>(i % 10);
    episodes.Add(episode, std::move(recording));
    ASSERT_LE(bytes.reserved_bytes(), 20 << 20);
  }
  const auto has_annotations = [&episodes](uint64_t fingerprint) {
    return !episodes.Find(3, fingerprint)->Decode().annotations.empty();
  };
  EXPECT_TRUE(has_annotations(20)) << "the best";
  EXPECT_TRUE(has_annotations(30)) << "the worst";
  EXPECT_TRUE(has_annotations(200)) << "the newest";
  EXPECT_FALSE(has_annotations(1));
  EXPECT_FALSE(has_annotations(21));
}

TEST(RecentEpisodesTest, MeanReturnsOfGroupsCoverTheirLastHundredEpisodes) {
  ByteBudget bytes(0);
  RecentEpisodes episodes(&bytes);
  for (int32_t i = 0; i < 300; ++i) {
    EndedEpisode episode;
    episode.environment = i % 2;
    episode.total_reward = i < 100 ? 1000 : static_cast<float>(episode.environment);
    episodes.Add(episode, std::nullopt);
  }
  EXPECT_THAT(episodes.ReadMeanReturns(
                  3, [](int32_t environment) { return static_cast<size_t>(environment); }),
              testing::ElementsAre(0, 1, std::nullopt));
}

}  // namespace
}  // namespace procgen
