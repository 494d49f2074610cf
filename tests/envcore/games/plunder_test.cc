#include "gtest/gtest.h"
#include "tests/envcore/games/staged_game.h"

namespace procgen {
namespace {

constexpr int kBallKind = 1;
constexpr int kLegendKind = 2;
constexpr int kShipKind = 7;

// A sea with only the player's ship, at the right, and the type of the targets.
struct Sea {
  std::unique_ptr<Game> game;
  int target_type = 0;
};

Sea StagedSea() {
  Sea sea = {StartedGame("plunder", 0)};
  for (const Entity& entity : sea.game->world().entities) {
    if (entity.kind == kLegendKind) {
      sea.target_type = entity.theme;
    }
  }
  StageAgentAlone(*sea.game, 18, 1.5F);
  return sea;
}

void AddAt(Game& game, int kind, float x, float y, int type = 0) {
  Stage(game).entities.push_back(Entity::Make(kind, x, y, 0, 0, 0.25F, 0.25F));
  Stage(game).entities.back().theme = type;
  Stage(game).entities.back().meets_entities = kind == kBallKind;
}

void HitShip(Game& game, int type) {
  AddAt(game, kShipKind, 5, 15, type);
  AddAt(game, kBallKind, 5, 15);
}

TEST(PlunderTest, AnEmptyReserveEndsTheEpisode) {
  const Sea sea = StagedSea();
  for (int hit = 0; hit < 9; ++hit) {
    HitShip(*sea.game, (sea.target_type + 1) % 6);
    sea.game->Play(kNoAction);
    EXPECT_FALSE(sea.game->outcome().done) << hit;
  }
  HitShip(*sea.game, (sea.target_type + 1) % 6);
  sea.game->Play(kNoAction);
  EXPECT_TRUE(sea.game->outcome().done);
  EXPECT_FALSE(sea.game->outcome().level_complete);
}

}  // namespace
}  // namespace procgen
