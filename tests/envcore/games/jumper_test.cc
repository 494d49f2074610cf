#include <algorithm>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/envcore/games/staged_game.h"

namespace procgen {
namespace {

using ::testing::ElementsAre;

constexpr int kSpikeManKind = 2;
constexpr int kGroundKind = 7;

constexpr int32_t kJump = 5;
constexpr float kOnFloor = 1 + 0.4F;  // y of a bunny on row 0

// A floor with only the bunny on it, at x = 5.5, and the carrot far away at the upper right.
std::unique_ptr<Game> StagedFloor() {
  auto game = StartedGame("jumper", 0);
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

bool ShowsJumpMark(const Game& game) {
  Scene scene;
  game.FillScene(&scene);
  return std::any_of(scene.overlays.begin(), scene.overlays.end(), [](const Overlay& overlay) {
    return overlay.shape == Overlay::Shape::kJumpMark;
  });
}

TEST(JumperTest, JumpsFromSupportAndOnceMoreInTheAirFourStepsLater) {
  const auto game = StagedFloor();
  EXPECT_THAT(StepsOfJumps(*game, 14), ElementsAre(4, 8));
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

TEST(JumperTest, OnlyAJumpInTheAirIsMarked) {
  const auto game = StagedFloor();
  PlayFor(*game, 4, kJump);
  EXPECT_FALSE(ShowsJumpMark(*game));
  PlayFor(*game, 4, kJump);
  EXPECT_TRUE(ShowsJumpMark(*game));
  game->Play(kJump);
  EXPECT_FALSE(ShowsJumpMark(*game));
}

}  // namespace
}  // namespace procgen
