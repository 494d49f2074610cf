#include "envcore/scene/art_slot.h"

#include <set>
#include <string>

#include "envcore/world/kinds.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

TEST(ArtSlotTest, SharedSlotsAreTheExplosionsAndTheTrail) {
  const absl::Span<const ArtSlot> slots = SharedArtSlots();
  ASSERT_EQ(slots.size(), 6U);
  for (int i = 0; i < 6; ++i) {
    EXPECT_EQ(slots[static_cast<size_t>(i)].kind, kExplosionKind + i);
    EXPECT_EQ(slots[static_cast<size_t>(i)].theme, 0);
  }
}

// The number of images decides a draw in every level.
TEST(ArtSlotTest, BackgroundGroupsHaveTheSizesOfTheSpecification) {
  EXPECT_EQ(BackgroundsOf(BackgroundGroup::kPlatform).size(), 62U);
  EXPECT_EQ(BackgroundsOf(BackgroundGroup::kSpace).size(), 13U);
  EXPECT_EQ(BackgroundsOf(BackgroundGroup::kTopdown).size(), 9U);
  EXPECT_EQ(BackgroundsOf(BackgroundGroup::kTopdownSimple).size(), 1U);
  EXPECT_EQ(BackgroundsOf(BackgroundGroup::kWater).size(), 7U);
  EXPECT_EQ(BackgroundsOf(BackgroundGroup::kWaterSurface).size(), 4U);
}

TEST(ArtSlotTest, TheSpaceGroupIsTheEndOfThePlatformGroup) {
  const auto platform = BackgroundsOf(BackgroundGroup::kPlatform);
  const auto space = BackgroundsOf(BackgroundGroup::kSpace);
  EXPECT_EQ(platform[49].upstream_path, space[0].upstream_path);
  EXPECT_EQ(platform.back().upstream_path, space.back().upstream_path);
}

TEST(ArtSlotTest, NoTwoBackgroundsOfAGroupAreTheSame) {
  for (const BackgroundGroup group :
       {BackgroundGroup::kPlatform, BackgroundGroup::kTopdown, BackgroundGroup::kWater}) {
    std::set<absl::string_view> names;
    std::set<absl::string_view> upstream_paths;
    for (const BackgroundSlot& slot : BackgroundsOf(group)) {
      EXPECT_TRUE(names.insert(slot.name).second) << slot.name;
      EXPECT_TRUE(upstream_paths.insert(slot.upstream_path).second) << slot.upstream_path;
    }
  }
}

}  // namespace
}  // namespace procgen
