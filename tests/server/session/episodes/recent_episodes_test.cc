#include "server/session/episodes/recent_episodes.h"

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

TEST(RecentEpisodesTest, WithoutEpisodesStatisticsAreZero) {
  const RecentEpisodes episodes;
  const RecentEpisodes::Summary none = episodes.Read();
  EXPECT_EQ(none.count, 0);
  EXPECT_EQ(none.mean_return, 0);
  EXPECT_EQ(none.mean_length, 0);
  EXPECT_EQ(episodes.ReadReturnSpread().deviation, 0);
  EXPECT_TRUE(episodes.ReadList(0).episodes.empty());
}

TEST(RecentEpisodesTest, StatisticsCoverTheLastHundred) {
  RecentEpisodes episodes;
  for (int32_t i = 0; i < 150; ++i) {
    episodes.Add(EpisodeOf(i));
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
  RecentEpisodes episodes;
  for (int32_t i = 0; i < 2500; ++i) {
    episodes.Add(EpisodeOf(i));
  }
  const RecentEpisodes::List all = episodes.ReadList(0);
  EXPECT_EQ(all.count, 2500);
  ASSERT_EQ(all.episodes.size(), 1000U);
  EXPECT_EQ(all.episodes.front().environment, 1500);
  EXPECT_EQ(all.episodes.back().environment, 2499);
  EXPECT_EQ(episodes.Read().mean_return, 2449.5);
}

TEST(RecentEpisodesTest, ListSkipsEpisodesThatTheReaderHas) {
  RecentEpisodes episodes;
  for (int32_t i = 0; i < 5; ++i) {
    episodes.Add(EpisodeOf(i));
  }
  const RecentEpisodes::List rest = episodes.ReadList(3);
  EXPECT_EQ(rest.count, 5);
  ASSERT_EQ(rest.episodes.size(), 2U);
  EXPECT_EQ(rest.episodes.front().environment, 3);
  EXPECT_TRUE(episodes.ReadList(5).episodes.empty());
  EXPECT_TRUE(episodes.ReadList(9).episodes.empty());
}

}  // namespace
}  // namespace procgen
