#include "envcore/pool/released_pictures.h"

#include <map>
#include <memory>
#include <string>

#include "envcore/games/game_catalog.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

std::map<std::string, RequiredImage> ByPath() {
  std::map<std::string, RequiredImage> pictures;
  for (const RequiredImage& picture : ReleasedPictures()) {
    EXPECT_TRUE(pictures.emplace(picture.path, picture).second) << picture.path << " twice";
  }
  return pictures;
}

TEST(ReleasedPicturesTest, EverySlotOfEveryGameHasItsPictureInItsOneSize) {
  const auto pictures = ByPath();
  for (const GameSpec& spec : GameCatalog()) {
    const std::unique_ptr<Game> game = spec.make(GameOptions());
    for (const ArtSlot& slot : game->art().slots) {
      const auto found = pictures.find(std::string(slot.released));
      ASSERT_NE(found, pictures.end()) << slot.released;
      EXPECT_EQ(found->second.width_px, slot.width_px) << slot.released;
      EXPECT_EQ(found->second.height_px, slot.height_px) << slot.released;
    }
  }
}

TEST(ReleasedPicturesTest, EveryBackgroundIsRequiredInAnySize) {
  const auto pictures = ByPath();
  for (const BackgroundGroup group :
       {BackgroundGroup::kPlatform, BackgroundGroup::kSpace, BackgroundGroup::kTopdown,
        BackgroundGroup::kTopdownSimple, BackgroundGroup::kWater, BackgroundGroup::kWaterSurface}) {
    for (const BackgroundSlot& slot : BackgroundsOf(group)) {
      const auto found = pictures.find(std::string(slot.released));
      ASSERT_NE(found, pictures.end()) << slot.released;
      EXPECT_EQ(found->second.width_px, 0) << slot.released;
    }
  }
}

TEST(ReleasedPicturesTest, ThereAreAsManyAsTheSpecificationNames) {
  EXPECT_EQ(ReleasedPictures().size(), 329U);
}

}  // namespace
}  // namespace procgen
