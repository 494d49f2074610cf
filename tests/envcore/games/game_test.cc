#include "envcore/games/game.h"

#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/envcore/games/scripted_game.h"

namespace procgen {
namespace {

using ::testing::ElementsAre;
using ::testing::Field;

// A scripted game in a level, with the agent at rest at the center of its world.
std::unique_ptr<ScriptedGame> StartedInTheMiddle(const GameOptions& options = {}) {
  auto game = std::make_unique<ScriptedGame>(options);
  game->StartLevel(1);
  game->world_.agent().x = 4;
  game->world_.agent().y = 4;
  return game;
}

TEST(GameTest, ANewLevelIsEmptyExceptForASmartAgentInLayerOne) {
  const auto game = StartedInTheMiddle();
  game->world_.grid.Set(0, kWallKind);
  game->world_.entities.push_back(Entity::Make(kThemedKind, 1, 1, 0, 0, 0.5F, 0.5F));
  game->StartLevel(2);
  EXPECT_EQ(game->world().grid.At(0), kEmptyKind);
  ASSERT_EQ(game->world().entities.size(), 1U);
  const Entity& agent = game->world().agent();
  EXPECT_EQ(agent.kind, kAgentKind);
  EXPECT_TRUE(agent.smart);
  EXPECT_EQ(agent.layer, 1);
  EXPECT_EQ(agent.rx, 0.4F);
}

TEST(GameTest, MovesSteerAndSpecialActionsDoNot) {
  const auto game = StartedInTheMiddle();
  for (int32_t action = 0; action < 9; ++action) {
    game->Play(action);
    const int column = action / 3;
    const int row = action % 3;
    EXPECT_EQ(game->world().controls.horizontal, static_cast<float>(column - 1)) << action;
    EXPECT_EQ(game->world().controls.vertical, static_cast<float>(row - 1)) << action;
    EXPECT_EQ(game->special_action_, 0);
  }
  for (int32_t action = 9; action < kActionCount; ++action) {
    game->Play(action);
    EXPECT_EQ(game->world().controls.horizontal, 0);
    EXPECT_EQ(game->world().controls.vertical, 0);
    EXPECT_EQ(game->special_action_, action - 8);
  }
}

TEST(GameTest, TheLastMoveSurvivesSpecialActionsAndLevels) {
  const auto game = StartedInTheMiddle();
  EXPECT_EQ(game->last_move_, 7);
  game->Play(kNoAction);
  EXPECT_EQ(game->last_move_, 7);
  game->Play(2);
  game->Play(9);
  game->StartLevel(5);
  game->Play(kNoAction);
  EXPECT_EQ(game->last_move_, 2);
}

TEST(GameTest, AnAgentOutOfTheWorldEndsTheLevel) {
  const auto game = StartedInTheMiddle();
  game->world_.agent().smart = false;
  game->world_.agent().x = -0.5F;
  game->Play(kNoAction);
  EXPECT_TRUE(game->outcome().done);
}

TEST(GameTest, MarkedEntitiesAreRemovedInTheSameStep) {
  const auto game = StartedInTheMiddle();
  Entity& thing =
      game->world_.entities.emplace_back(Entity::Make(kThemedKind, 1, 1, 0, 0, 0.5F, 0.5F));
  thing.expiry = 1;
  game->Play(kNoAction);
  EXPECT_EQ(game->world().entities.size(), 2U);
  game->Play(kNoAction);
  EXPECT_EQ(game->world().entities.size(), 1U);
}

// --- Themes and aspect ratios.

TEST(GameTest, AThemeIsDrawnEvenIfItsKindHasOnlyOne) {
  const auto game = StartedInTheMiddle();
  RandomStream same = game->random();
  EXPECT_EQ(game->DrawTheme(kThemedKind), same.Int(3));
  EXPECT_EQ(game->DrawTheme(kAgentKind), 0);
  EXPECT_EQ(game->random().draws(), 4U + 2U);
}

TEST(GameTest, AspectRatiosAreThoseOfUpstreamImages) {
  const auto game = StartedInTheMiddle();
  EXPECT_EQ(game->AspectRatio(kThemedKind, 1), 2);
  EXPECT_EQ(game->AspectRatio(kThemedKind, 2), static_cast<float>(1.0 / 3));
  EXPECT_EQ(game->AspectRatio(55, 0), static_cast<float>(57.0 / 56)) << "a shared slot";
  EXPECT_EQ(game->AspectRatio(77, 0), 1) << "no image";
}

TEST(GameTest, GeneratedArtHasOneSquareThemeAndMonochromeArtChangesNothing) {
  const auto generated = StartedInTheMiddle({.use_generated_assets = true});
  EXPECT_EQ(generated->DrawTheme(kThemedKind), 0);
  EXPECT_EQ(generated->AspectRatio(kThemedKind, 1), 1);
  const auto monochrome = StartedInTheMiddle({.use_monochrome_assets = true});
  EXPECT_EQ(monochrome->AspectRatio(kThemedKind, 1), 2);
}

// --- Scenes.

TEST(GameTest, ASceneHasTheLayersInOrderAndNoOthers) {
  const auto game = StartedInTheMiddle();
  for (const int layer : {0, 1, -1, 2, 0}) {
    Entity& thing =
        game->world_.entities.emplace_back(Entity::Make(kThemedKind, 1, 1, 0, 0, 0.5F, 0.5F));
    thing.layer = layer;
    thing.rx = static_cast<float>(game->world().entities.size());
  }
  Scene scene;
  game->FillScene(&scene);
  EXPECT_THAT(scene.below_cells, ElementsAre(Field(&Sprite::rx, 4)));
  EXPECT_THAT(scene.above_cells, ElementsAre(Field(&Sprite::rx, 2), Field(&Sprite::rx, 6),
                                             Field(&Sprite::rx, 0.4F), Field(&Sprite::rx, 3)));
}

}  // namespace
}  // namespace procgen
