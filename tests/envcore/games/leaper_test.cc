#include "gtest/gtest.h"
#include "tests/envcore/games/staged_game.h"

namespace procgen {
namespace {

constexpr int kLogKind = 1;
constexpr int kWaterKind = 3;

constexpr int32_t kRight = 7;

// A world of grass with the frog at (4.5, 0.5). Traffic enters at the sides and does not reach the
// frog before the tests end.
std::unique_ptr<Game> StagedGrass() {
  auto game = StartedGame("leaper", 0, {.distribution_mode = DistributionMode::kEasy});
  StageAgentAlone(*game, 4.5F, 0.5F);
  return game;
}

void AddAt(Game& game, int kind, float x, float y, float vx = 0) {
  const float rx = kind == kLogKind ? 0.45F : 0.5F;
  Stage(game).entities.push_back(Entity::Make(kind, x, y, vx, 0, rx, rx));
}

TEST(LeaperTest, WaterDrownsOnlyAFrogThatSits) {
  const auto game = StagedGrass();
  Stage(*game).grid.Fill(5, 0, 1, 1, kWaterKind);
  for (int step = 1; step <= 5; ++step) {
    game->Play(kRight);
    EXPECT_FALSE(game->outcome().done) << step;
  }
  game->Play(kNoAction);
  EXPECT_TRUE(game->outcome().done);
  EXPECT_EQ(game->outcome().reward, 0);
}

TEST(LeaperTest, ALogSavesAndCarries) {
  const auto game = StagedGrass();
  Stage(*game).grid.Fill(0, 0, game->world().grid.width(), 1, kWaterKind);
  AddAt(*game, kLogKind, 4.5F, 0.5F, 0.05F);
  for (int step = 0; step < 10; ++step) {
    game->Play(kNoAction);
    EXPECT_FALSE(game->outcome().done) << step;
  }
  EXPECT_NEAR(game->world().agent().x, 4.5F + 10 * 0.05F, 1e-5F);
}

}  // namespace
}  // namespace procgen
