#include "envcore/pool/upstream_images.h"

#include <map>
#include <memory>
#include <string>

#include "envcore/games/game_catalog.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

std::map<std::string, RequiredImage> ByPath() {
  std::map<std::string, RequiredImage> pictures;
  for (const RequiredImage& picture : UpstreamImages()) {
    EXPECT_TRUE(pictures.emplace(picture.path, picture).second) << picture.path << " twice";
  }
  return pictures;
}

TEST(UpstreamImagesTest, EverySlotOfEveryGameRequiresItsImageInItsSize) {
  const auto pictures = ByPath();
  for (const GameSpec& spec : GameCatalog()) {
    const std::unique_ptr<Game> game = spec.make(GameOptions());
    for (const ArtSlot& slot : game->art().slots) {
      const auto found = pictures.find(std::string(slot.upstream_path));
      ASSERT_NE(found, pictures.end()) << slot.upstream_path;
      EXPECT_EQ(found->second.width_px, slot.width_px) << slot.upstream_path;
      EXPECT_EQ(found->second.height_px, slot.height_px) << slot.upstream_path;
    }
  }
}

TEST(UpstreamImagesTest, TheirNumberIsThatOfTheSpecification) {
  EXPECT_EQ(UpstreamImages().size(), 329U);
}

}  // namespace
}  // namespace procgen
