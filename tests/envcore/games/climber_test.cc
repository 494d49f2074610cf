#include <algorithm>

#include "gtest/gtest.h"
#include "tests/envcore/games/staged_game.h"

namespace procgen {
namespace {

constexpr int kCrystalKind = 1;
constexpr int kFishKind = 5;
constexpr int kRockKind = 15;
constexpr int kPlatformKind = 16;

constexpr int32_t kJump = 5;
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

TEST(ClimberTest, CrystalsPayOneAndTheLastOneTenMore) {
  const auto game = StartedGame("climber", 0);
  const int crystal_count = CountEntities(*game, kCrystalKind);
  StageFloor(*game);
  for (int i = 1; i < crystal_count; ++i) {
    AddAt(*game, kCrystalKind, 5.5F, 1.5F);
  }
  game->Play(kNoAction);
  EXPECT_EQ(game->outcome().reward, static_cast<float>(crystal_count - 1));
  EXPECT_FALSE(game->outcome().done);
  EXPECT_EQ(CountEntities(*game, kCrystalKind), 0);

  AddAt(*game, kCrystalKind, 5.5F, 1.5F);
  AddAt(*game, kFishKind, 5.5F, 1.5F);
  game->Play(kNoAction);
  EXPECT_EQ(game->outcome().reward, 11) << "even with a fish in the same step";
  EXPECT_TRUE(game->outcome().level_complete);
  EXPECT_TRUE(game->outcome().done);
}

TEST(ClimberTest, AFishEndsTheEpisodeWithoutReward) {
  const auto game = StagedFloor();
  AddAt(*game, kFishKind, 5.5F, 1.5F);
  game->Play(kNoAction);
  EXPECT_EQ(game->outcome().reward, 0);
  EXPECT_TRUE(game->outcome().done);
  EXPECT_FALSE(game->outcome().level_complete);
}

TEST(ClimberTest, JumpsOnlyWithSupport) {
  const auto game = StagedFloor();
  game->Play(kJump);
  EXPECT_EQ(game->world().agent().vy, 1.5F);
  game->Play(kJump);
  EXPECT_EQ(game->world().agent().vy, 1.5F - 0.2F) << "gravity only";
}

TEST(ClimberTest, PlatformsCannotBeJumpedThroughFromBelow) {
  const auto game = StagedFloor();
  Stage(*game).grid.Set(5, 3, kPlatformKind);
  game->Play(kJump);
  game->Play(kNoAction);
  EXPECT_LE(game->world().agent().y, 2.5F);
}

TEST(ClimberTest, FishTurnFourCellsFromTheirPatrolCenter) {
  const auto game = StagedFloor();
  AddFish(*game, 10);
  float reach = 0;
  for (int step = 0; step < 200; ++step) {
    game->Play(kNoAction);
    reach = std::max(reach, std::abs(game->world().entities[1].x - 10));
  }
  EXPECT_GT(reach, 4);
  EXPECT_LT(reach, 4 + 2 * kFishSpeed);
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

TEST(ClimberTest, TheViewIsAsWideAsTheWorldWithTheAgentNearItsLowerEdge) {
  const auto game = StagedFloor();
  Scene scene;
  game->FillScene(&scene);
  EXPECT_EQ(scene.camera.cells, 20);
  EXPECT_EQ(scene.camera.center_x, 10);
  EXPECT_EQ(scene.camera.center_y, 1.5F + 7.5F);
}

TEST(ClimberTest, TheWholeWorldIsSeenWithoutCenterAgent) {
  const auto game = StartedGame("climber", 0, {.center_agent = false});
  Scene scene;
  game->FillScene(&scene);
  EXPECT_EQ(scene.camera.cells, 64);
  EXPECT_EQ(scene.camera.center_y, 32);
}

TEST(ClimberTest, EveryLevelHasACrystalAndEachFloatsOverAPlatform) {
  for (int32_t seed = 0; seed < 200; ++seed) {
    const auto game = StartedGame("climber", seed);
    EXPECT_GE(CountEntities(*game, kCrystalKind), 1);
    for (const Entity& entity : game->world().entities) {
      if (entity.kind == kCrystalKind) {
        EXPECT_EQ(game->world().CellAtPoint(entity.x, entity.y - 1), kPlatformKind);
      }
    }
  }
}

}  // namespace
}  // namespace procgen
