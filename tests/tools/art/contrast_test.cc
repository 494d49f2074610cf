// Measured with flat colors, whose contrast is known.

#include "tools/art/contrast.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "envcore/render/art/art_pack.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/envcore/render/one_colour_png.h"

namespace procgen {
namespace {

using ::testing::DoubleNear;

constexpr Rgba kWhite = {255, 255, 255, 255};
constexpr Rgba kGrey = {119, 119, 119, 255};  // half the lightness of white
constexpr Rgba kBlack = {0, 0, 0, 255};

constexpr Part kMouse = {.name = "mouse", .role = Role::kAgent, .image_kinds = {0}};
constexpr Part kWall = {.name = "wall", .role = Role::kBlocks, .image_kinds = {51}};

// The contrast of maze with a flat mouse, cheese and wall. The background is missing and therefore
// black.
Contrast ContrastOfMaze(const Rgba& figures, const Rgba& wall, absl::Span<const Part> parts) {
  const std::string figure_png = OneColourPng(16, 16, figures);
  const std::string wall_png = OneColourPng(16, 16, wall);
  const SharedArt art(std::make_shared<ArtPack>(
      ArtLayout::kOwn,
      std::vector<ArtFile>{
          {"maze/mouse_0", figure_png}, {"maze/cheese_0", figure_png}, {"maze/wall_0", wall_png}}));
  return MeasureContrast({"maze", DistributionMode::kHard, parts}, art);
}

TEST(ContrastTest, AViewThatIsHalfBlackAndHalfWhiteHasTheLargestContrast) {
  const std::vector<uint8_t> view = {0, 0, 0, 255, 255, 255};
  EXPECT_THAT(ContrastOf(view, view).view, DoubleNear(127.5, 1e-9));
  const std::vector<uint8_t> flat = {10, 200, 30, 10, 200, 30};
  EXPECT_EQ(ContrastOf(flat, flat).view, 0);
}

TEST(ContrastTest, ColorsOfEqualBrightnessHaveContrast) {
  // Deviations of 50, 50 and 0 in red, green and blue.
  const std::vector<uint8_t> view = {100, 0, 9, 0, 100, 9};
  EXPECT_THAT(ContrastOf(view, view).view, DoubleNear(40.82, 0.01));
}

TEST(ContrastTest, FiguresAreComparedWithWhatTheyCover) {
  const std::vector<uint8_t> bare = {0, 0, 0, 0, 0, 0, 0, 0, 0};
  const std::vector<uint8_t> view = {255, 255, 255, 119, 119, 119, 0, 0, 0};
  EXPECT_THAT(ContrastOf(view, bare).figures, DoubleNear(75, 0.2));
  EXPECT_EQ(ContrastOf(bare, bare).figures, 0);
}

TEST(ContrastTest, OnlyFiguresCountAsFigures) {
  const Part parts[] = {kMouse, kWall};
  EXPECT_THAT(ContrastOfMaze(kWhite, kBlack, parts).figures, DoubleNear(100, 0.2));
  EXPECT_THAT(ContrastOfMaze(kGrey, kWhite, parts).figures, DoubleNear(50, 0.2));
  EXPECT_EQ(ContrastOfMaze(kWhite, kWhite, {&kWall, 1}).figures, 0);
}

}  // namespace
}  // namespace procgen
