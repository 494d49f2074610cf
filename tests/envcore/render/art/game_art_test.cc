#include "envcore/render/art/game_art.h"

#include <thread>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

constexpr ArtSlot kSlots[] = {
    {0, 0, "mouse", "kenney/mouse.png", 64, 64},
    {54, 0, "wall", "topdown/wall.png", 64, 64},  // hides the shared explosion
};
constexpr int kBlocks[] = {7};

GameArt MazeArt() { return {ArtPack::Embedded(), "maze", kSlots, 3848665378U, kBlocks}; }

TEST(GameArtTest, FallsBackFromThePackToGeneratedImages) {
  const GameArt art = MazeArt();
  EXPECT_FALSE(art.SpriteOf(0, 0, false).generated);
  EXPECT_TRUE(art.SpriteOf(12, 0, false).generated);
  EXPECT_EQ(art.SpriteOf(12, 0, false).picture, art.GeneratedOf(12, false).picture);
}

TEST(GameArtTest, SharedSlotsServeKindsWithoutTheirOwn) {
  const GameArt art = MazeArt();
  EXPECT_FALSE(art.SpriteOf(55, 0, false).generated);
  EXPECT_NE(art.SpriteOf(54, 0, false).picture, art.SpriteOf(55, 0, false).picture);
}

TEST(GameArtTest, MissingThemesShowThemeZero) {
  const GameArt art = MazeArt();
  EXPECT_EQ(art.SpriteOf(0, 4, false).picture, art.SpriteOf(0, 0, false).picture);
  EXPECT_EQ(art.SpriteOf(0, -1, false).picture, art.SpriteOf(0, 0, false).picture);
}

TEST(GameArtTest, OnlyBlockShapedKindsFillTheirCanvas) {
  const GameArt art = MazeArt();
  EXPECT_TRUE(art.GeneratedOf(7, false).picture->opaque());
  EXPECT_FALSE(art.GeneratedOf(8, false).picture->opaque());
}

TEST(GameArtTest, MirroringTwiceGivesTheSameImage) {
  const GameArt art = MazeArt();
  const Image& plain = art.GeneratedOf(3, false).picture->level(0);
  const Image& mirrored = art.GeneratedOf(3, true).picture->level(0);
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      EXPECT_EQ(mirrored.At(x, y), plain.At(63 - x, y));
    }
  }
}

TEST(GameArtTest, ConcurrentRequestsGetTheSameImage) {
  const GameArt art = MazeArt();
  std::vector<const MipmappedImage*> pictures(8);
  std::vector<std::thread> threads;
  threads.reserve(pictures.size());
  for (const MipmappedImage*& picture : pictures) {
    threads.emplace_back([&] { picture = art.GeneratedOf(9, true).picture; });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  EXPECT_NE(pictures[0], nullptr);
  EXPECT_THAT(pictures, ::testing::Each(pictures[0]));
}

}  // namespace
}  // namespace procgen
