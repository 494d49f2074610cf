#include <algorithm>
#include <cmath>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/envcore/games/staged_game.h"

namespace procgen {
namespace {

using ::testing::ElementsAre;

constexpr int kCarrotKind = 1;
constexpr int kSpikeManKind = 2;
constexpr int kGroundKind = 7;

constexpr int32_t kJump = 5;
constexpr int32_t kRight = 7;
constexpr float kOnFloor = 1 + 0.4F;  // y of a bunny on row 0

// A floor with only the bunny on it, at x = 5.5, and the carrot far away at the upper right.
std::unique_ptr<Game> StagedFloor(const GameOptions& options = {}) {
  auto game = StartedGame("jumper", 0, options);
  Entity carrot = game->world().entities[1];
  StageAgentAlone(*game, 5.5F, kOnFloor);
  carrot.x = 15.5F;
  carrot.y = kOnFloor + 10;
  Stage(*game).entities.push_back(carrot);
  Stage(*game).grid.Fill(0, 0, game->world().grid.width(), 1, kGroundKind);
  return game;
}

void PlayFor(Game& game, int steps, int32_t action) {
  for (int i = 0; i < steps; ++i) {
    game.Play(action);
  }
}

// The steps among `step_count` in which the bunny jumps while up is held.
std::vector<int> StepsOfJumps(Game& game, int step_count) {
  std::vector<int> steps;
  for (int step = 1; step <= step_count; ++step) {
    const float vy = game.world().agent().vy;
    game.Play(kJump);
    if (game.world().agent().vy > vy) {
      steps.push_back(step);
    }
  }
  return steps;
}

std::vector<Overlay> OverlaysOf(const Game& game) {
  Scene scene;
  game.FillScene(&scene);
  return scene.overlays;
}

bool ShowsJumpMark(const Game& game) {
  const std::vector<Overlay> overlays = OverlaysOf(game);
  return std::any_of(overlays.begin(), overlays.end(), [](const Overlay& overlay) {
    return overlay.shape == Overlay::Shape::kJumpMark;
  });
}

TEST(JumperTest, JumpsFromSupportAndOnceMoreInTheAirFourStepsLater) {
  const auto game = StagedFloor();
  EXPECT_THAT(StepsOfJumps(*game, 14), ElementsAre(4, 8));
}

TEST(JumperTest, WalkingOffALedgeKeepsBothJumps) {
  const auto game = StagedFloor();
  game->Play(kNoAction);  // computes has_support_
  Stage(*game).agent().y = 20;
  EXPECT_THAT(StepsOfJumps(*game, 14), ElementsAre(3, 7));
}

TEST(JumperTest, RestsOnTheGroundWithoutDust) {
  const auto game = StagedFloor();
  PlayFor(*game, 10, kNoAction);
  EXPECT_EQ(game->world().agent().y, kOnFloor);
  EXPECT_EQ(game->world().entities.size(), 2U);
}

TEST(JumperTest, RaisesDustAsItRuns) {
  const auto game = StagedFloor();
  PlayFor(*game, 3, kRight);
  EXPECT_EQ(game->world().entities.size(), 2U + 3);
  EXPECT_EQ(game->world().entities.back().kind, kTrailKind);
}

TEST(JumperTest, TheCarrotPaysTenAndCompletesEvenWithASpikeMan) {
  const auto game = StagedFloor();
  Stage(*game).entities[1].x = 5.5F;
  Stage(*game).entities[1].y = kOnFloor;
  Stage(*game).entities.push_back(Entity::Make(kSpikeManKind, 5.5F, kOnFloor, 0, 0, 0.23F, 0.4F));
  game->Play(kNoAction);
  EXPECT_EQ(game->outcome().reward, 10);
  EXPECT_TRUE(game->outcome().done);
  EXPECT_TRUE(game->outcome().level_complete);
}

TEST(JumperTest, ASpikeManEndsTheEpisode) {
  const auto game = StagedFloor();
  Stage(*game).entities.push_back(Entity::Make(kSpikeManKind, 5.5F, kOnFloor, 0, 0, 0.23F, 0.4F));
  game->Play(kNoAction);
  EXPECT_EQ(game->outcome().reward, 0);
  EXPECT_TRUE(game->outcome().done);
  EXPECT_FALSE(game->outcome().level_complete);
}

TEST(JumperTest, TheCompassPointsToTheCarrotAndShowsItsDistance) {
  const auto game = StagedFloor();
  const std::vector<Overlay> overlays = OverlaysOf(*game);
  ASSERT_EQ(overlays.size(), 3U);
  EXPECT_EQ(overlays[0].shape, Overlay::Shape::kDisc);
  EXPECT_EQ(overlays[0].x, 16 - 2 - 0.25F);
  EXPECT_EQ(overlays[1].shape, Overlay::Shape::kNeedle);
  EXPECT_FLOAT_EQ(overlays[1].angle, std::atan2(1.0F, 1.0F));
  EXPECT_EQ(overlays[2].shape, Overlay::Shape::kRectangle);
  EXPECT_FLOAT_EQ(overlays[2].width, 2 * 10.0F / 40);
}

TEST(JumperTest, OnlyAJumpInTheAirIsMarked) {
  const auto game = StagedFloor();
  PlayFor(*game, 4, kJump);
  EXPECT_FALSE(ShowsJumpMark(*game));
  PlayFor(*game, 4, kJump);
  EXPECT_TRUE(ShowsJumpMark(*game));
  game->Play(kJump);
  EXPECT_FALSE(ShowsJumpMark(*game));
}

TEST(JumperTest, MemoryModeHasNeitherCompassNorSpikeMen) {
  for (int32_t seed = 0; seed < 10; ++seed) {
    const auto game = StartedGame("jumper", seed, {.distribution_mode = DistributionMode::kMemory});
    EXPECT_TRUE(OverlaysOf(*game).empty());
    EXPECT_EQ(game->world().entities.size(), 2U);
  }
}

TEST(JumperTest, LevelsHaveOneCarrotAndSpikeMenApartOnTheGround) {
  for (int32_t seed = 0; seed < 50; ++seed) {
    const auto game = StartedGame("jumper", seed);
    const std::vector<Entity>& entities = game->world().entities;
    ASSERT_EQ(entities[1].kind, kCarrotKind);
    for (size_t i = 2; i < entities.size(); ++i) {
      ASSERT_EQ(entities[i].kind, kSpikeManKind);
      const bool is_beside_last =
          entities[i].y == entities[i - 1].y && entities[i].x - entities[i - 1].x <= 1;
      EXPECT_FALSE(i > 2 && is_beside_last);
    }
  }
}

}  // namespace
}  // namespace procgen
