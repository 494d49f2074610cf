#include "envcore/render/scene/tiles.h"

#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

using ::testing::SizeIs;

std::vector<ScreenRect> TilesOf(const ScreenRect& rect, float ratio) {
  std::vector<ScreenRect> tiles;
  ForEachTile(rect, ratio, [&](const ScreenRect& tile) { tiles.push_back(tile); });
  return tiles;
}

TEST(TilesTest, ABoxIsDividedSideBySide) {
  const auto tiles = TilesOf({1, 2, 7, 2}, 1);
  ASSERT_THAT(tiles, SizeIs(3));
  EXPECT_FLOAT_EQ(static_cast<float>(tiles[1].x), 1 + 7.0F / 3);
  EXPECT_FLOAT_EQ(static_cast<float>(tiles[1].width), 7.0F / 3);
  EXPECT_EQ(tiles[1].y, 2);
  EXPECT_EQ(tiles[1].height, 2);
}

TEST(TilesTest, ANegativeRatioDividesDownward) {
  const auto tiles = TilesOf({1, 2, 2, 8}, -2);
  ASSERT_THAT(tiles, SizeIs(2));
  EXPECT_EQ(tiles[1].x, 1);
  EXPECT_EQ(tiles[1].y, 6);
  EXPECT_EQ(tiles[1].height, 4);
}

TEST(TilesTest, ABoxShorterThanATileIsOneTile) { EXPECT_THAT(TilesOf({0, 0, 1, 2}, 1), SizeIs(1)); }

// A snapshot can contain walls of any breadth.
TEST(TilesTest, TheNumberOfTilesIsLimited) {
  EXPECT_THAT(TilesOf({0, 0, 64, 0}, 1), SizeIs(kTileCountMax));
  EXPECT_THAT(TilesOf({0, 0, 1e-30, 64}, -1), SizeIs(kTileCountMax));
  EXPECT_THAT(TilesOf({0, 0, 0, 0}, 1), SizeIs(1));
}

}  // namespace
}  // namespace procgen
