#include "gtest/gtest.h"
#include "tests/envcore/games/staged_game.h"

namespace procgen {
namespace {

constexpr int kFishKind = 2;

// A hard level with only the agent (half-size 0.5) in the middle.
std::unique_ptr<Game> QuietTank() {
  auto game = StartedGame("bigfish", 0);
  StageAgentAlone(*game, 10, 10);
  return game;
}

// Adds a fish at rest on the agent.
void AddFish(Game& game, float radius) {
  Stage(game).entities.push_back(Entity::Make(kFishKind, 10, 10, 0, 0, radius, radius));
}

// Ignores fish that entered at the edges.
int FishInTheMiddle(const Game& game) {
  int count = 0;
  for (const Entity& entity : game.world().entities) {
    count += entity.kind == kFishKind && entity.x == 10 ? 1 : 0;
  }
  return count;
}

TEST(BigFishTest, AWiderFishEndsTheEpisodeAndStays) {
  const auto game = QuietTank();
  AddFish(*game, 0.500001F);
  game->Play(kNoAction);
  EXPECT_EQ(game->outcome().reward, 0);
  EXPECT_TRUE(game->outcome().done);
  EXPECT_FALSE(game->outcome().level_complete);
  EXPECT_EQ(FishInTheMiddle(*game), 1);
}

TEST(BigFishTest, OnlyWidthsAreCompared) {
  const auto game = QuietTank();
  AddFish(*game, 0.5F);
  Stage(*game).entities.back().ry = 3;
  game->Play(kNoAction);
  EXPECT_EQ(game->outcome().reward, 1);
}

TEST(BigFishTest, GrowthCountsForFishThatAreMetLaterInTheSameStep) {
  const auto game = QuietTank();
  AddFish(*game, 0.52F);
  AddFish(*game, 0.5F);  // met first
  game->Play(kNoAction);
  EXPECT_EQ(game->outcome().reward, 2);
  EXPECT_FALSE(game->outcome().done);
}

}  // namespace
}  // namespace procgen
