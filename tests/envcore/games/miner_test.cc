#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/envcore/games/staged_game.h"

namespace procgen {
namespace {

using ::testing::ElementsAre;

constexpr int kExitKindOfMiner = 6;
constexpr int32_t kLeft = 1;
constexpr int32_t kRight = 7;

// o boulder, * diamond, O and + the same while falling, % dirt. In drawings of the initial state
// also: @ the robot, E the exit, both in empty cells. In drawings of the result: only @.
const Legend& MinerLegend() {
  static const Legend legend = {{'.', kEmptyKind}, {'o', 1}, {'*', 2},
                                {'O', 3},          {'+', 4}, {'%', 9}};
  return legend;
}

void StageMine(Game& game, const Drawing& rows) {
  World& world = Stage(game);
  DrawGrid(rows, MinerLegend(), &world.grid);
  world.entities.resize(1);
  const auto height = static_cast<int>(rows.size());
  for (int row = 0; row < height; ++row) {
    const std::string& cells = rows[static_cast<size_t>(row)];
    const auto y = static_cast<float>(height - 1 - row) + 0.5F;
    if (const size_t x = cells.find('@'); x != std::string::npos) {
      world.agent().x = static_cast<float>(x) + 0.5F;
      world.agent().y = y;
    }
    if (const size_t x = cells.find('E'); x != std::string::npos) {
      world.entities.push_back(
          Entity::Make(kExitKindOfMiner, static_cast<float>(x) + 0.5F, y, 0, 0, 0.5F, 0.5F));
    }
  }
}

std::unique_ptr<Game> StagedMine(const Drawing& rows) {
  auto game = StartedGame("miner", 0, {.distribution_mode = DistributionMode::kEasy});
  StageMine(*game, rows);
  return game;
}

Drawing DrawnMine(const Game& game) {
  const World& world = game.world();
  Drawing rows = Drawn(world.grid, MinerLegend());
  const auto row = static_cast<size_t>(world.grid.height() - 1 - static_cast<int>(world.agent().y));
  rows[row][static_cast<size_t>(world.agent().x)] = '@';
  return rows;
}

// The mine after taking `action` in the drawn mine.
Drawing After(const Drawing& rows, int32_t action) {
  const auto game = StagedMine(rows);
  game->Play(action);
  return DrawnMine(*game);
}

// --- Collecting, pushing.

TEST(MinerTest, AFallingDiamondInItsCellIsCollectedOnlyOnceItRests) {
  const auto game = StagedMine({"@%%", "%%%"});
  Stage(*game).grid.Set(0, 1, 4);
  game->Play(kNoAction);
  EXPECT_EQ(game->outcome().reward, 0);
  game->Play(kNoAction);
  EXPECT_EQ(game->outcome().reward, 1);
}

TEST(MinerTest, PushesToTheWorldsLastColumnAndNoFurther) {
  EXPECT_THAT(After({"@o."}, kRight), ElementsAre(".@o"));
  EXPECT_THAT(After({".o@"}, kLeft), ElementsAre("o@."));
  EXPECT_THAT(After({".@o"}, kRight), ElementsAre(".@o"));
  EXPECT_THAT(After({"o@."}, kLeft), ElementsAre("o@."));
}

// By index, the next cell is the first of the row above.
TEST(MinerTest, DoesNotPushAroundTheWorldsEdge) {
  EXPECT_THAT(After({".%",  //
                     "@o"},
                    kRight),
              ElementsAre(".%", "@o"));
}

// --- The exit.

TEST(MinerTest, TheExitPaysInTheStepAfterTheLastDiamond) {
  const auto game = StagedMine({"@*E"});
  game->Play(kRight);
  EXPECT_EQ(game->outcome().reward, 1);
  game->Play(kRight);
  EXPECT_EQ(game->outcome().reward, 10);
  EXPECT_TRUE(game->outcome().done);
  EXPECT_TRUE(game->outcome().level_complete);
}

TEST(MinerTest, InTheFirstStepTheDiamondCountIsZero) {
  const auto game = StagedMine({"@E*"});
  game->Play(kRight);
  EXPECT_EQ(game->outcome().reward, 10);
}

TEST(MinerTest, ANewLevelStartsWithTheCountOfTheOldOne) {
  const auto game = StagedMine({"@%*"});
  game->Play(kNoAction);  // counts one diamond
  game->StartLevel(1);
  StageMine(*game, {"@E%"});
  game->Play(kRight);
  EXPECT_EQ(game->outcome().reward, 0) << "the old diamond still counts";
  game->Play(kNoAction);
  EXPECT_EQ(game->outcome().reward, 10) << "the last step counted none";
}

TEST(MinerTest, APushOntoTheExitPaysAfterTheNextMotion) {
  const auto game = StagedMine({"@o.%"});
  Stage(*game).entities.push_back(Entity::Make(kExitKindOfMiner, 1.5F, 0.5F, 0, 0, 0.5F, 0.5F));
  game->Play(kRight);
  EXPECT_EQ(game->outcome().reward, 0);
  game->Play(kNoAction);
  EXPECT_EQ(game->outcome().reward, 10);
}

}  // namespace
}  // namespace procgen
