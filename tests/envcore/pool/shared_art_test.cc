#include "envcore/pool/shared_art.h"

#include "envcore/games/game_catalog.h"
#include "envcore/render/art_pack.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

TEST(SharedArtTest, PoolsShareTheArtOfAGame) {
  const GameFacts& game = *FindGame("maze");
  const std::unique_ptr<Game> first = game.make(GameOptions());
  const std::unique_ptr<Game> second = game.make(GameOptions());
  EXPECT_EQ(SharedArt(game, first->art()), SharedArt(game, second->art()));
}

TEST(SharedArtTest, EverySlotOfEveryGameHasAPictureOfOurOwn) {
  const std::shared_ptr<const ArtPack> pack = ArtPack::Embedded();
  for (const GameFacts& facts : GameCatalog()) {
    const std::unique_ptr<Game> game = facts.make(GameOptions());
    for (const ArtSlot& slot : game->art().slots) {
      EXPECT_NE(pack->Sprite(facts.name, slot), nullptr)
          << facts.name << "/" << slot.name << "_" << slot.theme;
    }
  }
}

TEST(SharedArtTest, EveryBackgroundHasAPictureOfOurOwn) {
  const std::shared_ptr<const ArtPack> pack = ArtPack::Embedded();
  for (const BackgroundGroup group :
       {BackgroundGroup::kPlatform, BackgroundGroup::kSpace, BackgroundGroup::kTopdown,
        BackgroundGroup::kTopdownSimple, BackgroundGroup::kWater, BackgroundGroup::kWaterSurface}) {
    for (const BackgroundSlot& slot : BackgroundsOf(group)) {
      EXPECT_NE(pack->Background(slot), nullptr) << slot.name;
    }
  }
}

}  // namespace
}  // namespace procgen
