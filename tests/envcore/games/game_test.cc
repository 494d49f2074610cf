#include "envcore/games/game.h"

#include "gtest/gtest.h"
#include "tests/envcore/games/scripted_game.h"

namespace procgen {
namespace {

// A scripted game in a level, with the agent at rest at the center of its world.
std::unique_ptr<ScriptedGame> StartedInTheMiddle(const GameOptions& options = {}) {
  auto game = std::make_unique<ScriptedGame>(options);
  game->StartLevel(1);
  game->world_.agent().x = 4;
  game->world_.agent().y = 4;
  return game;
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

// --- Themes and aspect ratios.

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

}  // namespace
}  // namespace procgen
