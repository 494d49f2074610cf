// Measured with flat colors, whose distances are known.

#include "tools/art/legibility.h"

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "envcore/render/art/art_pack.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/envcore/render/one_colour_png.h"

namespace procgen {
namespace {

using ::testing::FloatNear;

constexpr Rgba kWhite = {255, 255, 255, 255};
constexpr Rgba kGrey = {119, 119, 119, 255};  // half the lightness of white

constexpr Part kMouse = {.name = "mouse", .role = Role::kAgent, .image_kinds = {0}};
constexpr Part kCheese = {.name = "cheese", .role = Role::kPays, .image_kinds = {2}};

// Art of maze in which mouse and cheese are flat squares. The background is missing and therefore
// black.
class FlatArt {
 public:
  FlatArt(const Rgba& mouse, const Rgba& cheese)
      : pngs_({OneColourPng(16, 16, mouse), OneColourPng(16, 16, cheese)}),
        art_(std::make_shared<ArtPack>(
            ArtLayout::kOwn,
            std::vector<ArtFile>{{"maze/mouse_0", pngs_[0]}, {"maze/cheese_0", pngs_[1]}})) {}

  std::vector<PartDistance> Compare(absl::Span<const Part> parts) const {
    return CompareParts({"maze", DistributionMode::kHard, parts}, art_);
  }

 private:
  std::vector<std::string> pngs_;
  SharedArt art_;
};

float DistanceOf(const std::vector<PartDistance>& likenesses, const Part* first,
                 const Part* second) {
  const auto found =
      std::find_if(likenesses.begin(), likenesses.end(), [&](const PartDistance& likeness) {
        return likeness.first == first && likeness.second == second;
      });
  return found == likenesses.end() ? -1 : found->distance;
}

TEST(LegibilityTest, FlatPartsAreAsFarApartAsTheirColors) {
  const Part parts[] = {kMouse, kCheese};
  const auto likenesses = FlatArt(kWhite, kGrey).Compare(parts);
  EXPECT_EQ(likenesses.size(), 3);
  EXPECT_THAT(DistanceOf(likenesses, &parts[0], &parts[1]), FloatNear(50, 0.2F));
  EXPECT_THAT(DistanceOf(likenesses, &parts[0], nullptr), FloatNear(100, 0.2F));
  EXPECT_THAT(DistanceOf(likenesses, &parts[1], nullptr), FloatNear(50, 0.2F));
}

TEST(LegibilityTest, TheClosestPairComesFirst) {
  const Part parts[] = {kMouse, kCheese};
  const auto likenesses = FlatArt(kWhite, kWhite).Compare(parts);
  ASSERT_FALSE(likenesses.empty());
  EXPECT_EQ(likenesses.front().first, &parts[0]);
  EXPECT_EQ(likenesses.front().second, &parts[1]);
  EXPECT_EQ(likenesses.front().distance, 0);
}

TEST(LegibilityTest, PartsThatDifferOnlyInSizeAreApart) {
  Part small_cheese = kCheese;
  small_cheese.width = 0.5F;
  small_cheese.height = 0.5F;
  const Part parts[] = {kMouse, small_cheese};
  // 3 x 3 pixels and 1 x 1 pixel, white: 8 pixels differ by 100 each; divided by the 1 pixel of the
  // smaller.
  const auto likenesses = FlatArt(kWhite, kWhite).Compare(parts);
  EXPECT_THAT(DistanceOf(likenesses, &parts[0], &parts[1]), FloatNear(800, 1));
}

TEST(LegibilityTest, PartsThatAreNeverSeenOnTheSameBackdropAreNotCompared) {
  Part cheese = kCheese;
  cheese.backdrops = {0};  // on a floor of mouse images
  const Part parts[] = {kMouse, cheese};
  const auto likenesses = FlatArt(kWhite, kGrey).Compare(parts);
  EXPECT_EQ(DistanceOf(likenesses, &parts[0], &parts[1]), -1);
  EXPECT_THAT(DistanceOf(likenesses, &parts[1], nullptr), FloatNear(50, 0.2F));
  EXPECT_EQ(likenesses.size(), 2);
}

}  // namespace
}  // namespace procgen
