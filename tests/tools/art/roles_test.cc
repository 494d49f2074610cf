#include "tools/art/roles.h"

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "envcore/games/game.h"
#include "envcore/games/game_catalog.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

using ::testing::Contains;
using ::testing::ElementsAreArray;

TEST(RolesTest, EachGameHasRolesInOneOfItsModes) {
  std::vector<absl::string_view> games;
  for (const Roles& roles : AllRoles()) {
    games.push_back(roles.game);
    EXPECT_TRUE(FindGame(roles.game)->HasMode(roles.mode)) << roles.game;
    EXPECT_EQ(&RolesOf(roles.game), &roles);
  }
  std::vector<absl::string_view> catalog;
  for (const GameSpec& spec : GameCatalog()) {
    catalog.push_back(spec.name);
  }
  EXPECT_THAT(games, ElementsAreArray(catalog));
}

TEST(RolesTest, PartsAndBackdropsShowImagesOfTheirGame) {
  for (const Roles& roles : AllRoles()) {
    const std::unique_ptr<Game> game = FindGame(roles.game)->make(GameOptions());
    std::vector<int> kinds = {kDotImage, kBackgroundBackdrop};
    for (const ArtSlot& slot : game->art().slots) {
      kinds.push_back(slot.kind);
    }
    for (const Part& part : roles.parts) {
      EXPECT_NE(part.image_kinds.begin(), part.image_kinds.end()) << roles.game << part.name;
      for (const int kind : part.image_kinds) {
        EXPECT_THAT(kinds, Contains(kind)) << roles.game << " " << part.name;
      }
      for (const int kind : part.backdrops) {
        EXPECT_THAT(kinds, Contains(kind)) << roles.game << " " << part.name;
      }
    }
  }
}

TEST(RolesTest, OnlyNamedPartsOfOneRoleMustDiffer) {
  const Part agent = {.name = "agent", .role = Role::kAgent};
  const Part saw = {.name = "saw", .role = Role::kKills};
  const Part lava = {.name = "lava", .role = Role::kKills};
  const Part red_key = {.name = "red key", .role = Role::kNamed};
  const Part blue_key = {.name = "blue key", .role = Role::kNamed};
  EXPECT_TRUE(MustDiffer(agent, saw));
  EXPECT_FALSE(MustDiffer(saw, lava));
  EXPECT_TRUE(MustDiffer(red_key, blue_key));
}

}  // namespace
}  // namespace procgen
