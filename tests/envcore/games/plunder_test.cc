#include "gtest/gtest.h"
#include "tests/envcore/games/staged_game.h"

namespace procgen {
namespace {

constexpr int kBallKind = 1;
constexpr int kLegendKind = 2;
constexpr int kPanelKind = 6;
constexpr int kShipKind = 7;

constexpr float kHitReserve = 0.1F;

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

// The reserve as shown by the upper bar.
float Reserve(const Game& game) {
  Scene scene;
  game.FillScene(&scene);
  return scene.overlays.front().width / 20;
}

TEST(PlunderTest, OnlyTheShipOfTheLegendPays) {
  for (const bool is_target : {true, false}) {
    const Sea sea = StagedSea();
    HitShip(*sea.game, is_target ? sea.target_type : (sea.target_type + 1) % 6);
    sea.game->Play(kNoAction);
    EXPECT_EQ(sea.game->outcome().reward, is_target ? 1 : 0);
    EXPECT_FALSE(sea.game->outcome().done);
    EXPECT_EQ(CountEntities(*sea.game, kExplosionKind), 1);
  }
}

TEST(PlunderTest, AWrongHitDrainsTheReserveAndARightOneRefillsIt) {
  const Sea sea = StagedSea();
  HitShip(*sea.game, (sea.target_type + 1) % 6);
  sea.game->Play(kNoAction);
  const float drained = Reserve(*sea.game);
  EXPECT_NEAR(drained, 1 - kHitReserve - 0.0015F, 1e-5F);
  HitShip(*sea.game, sea.target_type);
  sea.game->Play(kNoAction);
  EXPECT_NEAR(Reserve(*sea.game), drained + kHitReserve - 0.0015F, 1e-5F);
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

TEST(PlunderTest, TheTwentiethHitPaysTenMoreAndCompletes) {
  const Sea sea = StagedSea();
  for (int hit = 1; hit <= 19; ++hit) {
    HitShip(*sea.game, sea.target_type);
    sea.game->Play(kNoAction);
    EXPECT_EQ(sea.game->outcome().reward, 1);
  }
  HitShip(*sea.game, sea.target_type);
  sea.game->Play(kNoAction);
  EXPECT_EQ(sea.game->outcome().reward, 11);
  EXPECT_TRUE(sea.game->outcome().level_complete);
}

TEST(PlunderTest, APanelAbsorbsABall) {
  const Sea sea = StagedSea();
  AddAt(*sea.game, kPanelKind, 5, 7);
  AddAt(*sea.game, kBallKind, 5, 7);
  sea.game->Play(kNoAction);
  EXPECT_EQ(CountEntities(*sea.game, kBallKind), 0);
  EXPECT_EQ(CountEntities(*sea.game, kPanelKind), 1);
  EXPECT_NEAR(Reserve(*sea.game), 1 - 0.0015F, 1e-5F);
}

}  // namespace
}  // namespace procgen
