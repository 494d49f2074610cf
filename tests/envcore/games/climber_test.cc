#include "gtest/gtest.h"
#include "tests/envcore/games/staged_game.h"

namespace procgen {
namespace {

constexpr int kFishKind = 5;
constexpr int kRockKind = 15;
constexpr int kPlatformKind = 16;

constexpr float kFishSpeed = 0.15F;

// A floor with only the agent on it, at x = 5.5.
void StageFloor(Game& game) {
  StageAgentAlone(game, 5.5F, 1.5F);
  Stage(game).grid.Fill(0, 0, game.world().grid.width(), 1, kPlatformKind);
}

std::unique_ptr<Game> StagedFloor() {
  auto game = StartedGame("climber", 0);
  StageFloor(*game);
  return game;
}

Entity& AddAt(Game& game, int kind, float x, float y) {
  return Stage(game).entities.emplace_back(Entity::Make(kind, x, y, 0, 0, 0.3F, 0.3F));
}

Entity& AddFish(Game& game, float x) {
  Entity& fish = AddAt(game, kFishKind, x, 8.5F);
  fish.rx = 0.5F;
  fish.vx = kFishSpeed;
  fish.smart = true;
  fish.patrol_center = x;
  return fish;
}

// The speed of a fish after one contact with a cell of `kind`.
float SpeedAfterMeeting(int kind) {
  const auto game = StagedFloor();
  Stage(*game).grid.Set(12, 8, kind);
  AddFish(*game, 11.45F);
  game->Play(kNoAction);
  EXPECT_TRUE(game->world().entities[1].mirrored);
  return game->world().entities[1].vx;
}

TEST(ClimberTest, FishLoseAQuarterOfTheirSpeedAtRockAndNothingAtPlatforms) {
  EXPECT_EQ(SpeedAfterMeeting(kRockKind), -kFishSpeed * 0.75F);
  EXPECT_EQ(SpeedAfterMeeting(kPlatformKind), -kFishSpeed);
}

}  // namespace
}  // namespace procgen
