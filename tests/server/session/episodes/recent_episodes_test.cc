#include "server/session/episodes/recent_episodes.h"

#include "gtest/gtest.h"

namespace procgen {
namespace {

TEST(RecentEpisodesTest, WithoutEpisodesMeansAreZero) {
  const RecentEpisodes::Summary none = RecentEpisodes().Read();
  EXPECT_EQ(none.count, 0);
  EXPECT_EQ(none.mean_return, 0);
  EXPECT_EQ(none.mean_length, 0);
}

TEST(RecentEpisodesTest, MeansAreOfTheLastHundred) {
  RecentEpisodes episodes;
  for (int32_t i = 0; i < 150; ++i) {
    episodes.Add(static_cast<float>(i), 2 * i);
  }
  const RecentEpisodes::Summary summary = episodes.Read();
  EXPECT_EQ(summary.count, 150);
  EXPECT_FLOAT_EQ(summary.mean_return, 99.5);  // of 50 to 149
  EXPECT_FLOAT_EQ(summary.mean_length, 199);
}

}  // namespace
}  // namespace procgen
