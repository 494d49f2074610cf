#include "gtest/gtest.h"
#include "tests/envcore/games/staged_game.h"

namespace procgen {
namespace {

constexpr int kCoinKind = 1;
constexpr int kSawKind = 2;
constexpr int kWalkerKind = 5;
constexpr int kGroundTopKind = 16;
constexpr int kLavaKind = 17;
constexpr int kLavaSurfaceKind = 18;
constexpr int kCrateKind = 20;

constexpr float kRadiusY = 0.5787F;       // of the agent
constexpr float kOnFloor = 1 + kRadiusY;  // y of an agent on row 0
constexpr int32_t kDown = 3;

// A wide floor with only the agent on it, at x = 5.5.
std::unique_ptr<Game> StagedFloor(float y = kOnFloor) {
  auto game = StartedGame("coinrun", 0);
  StageAgentAlone(*game, 5.5F, y);
  World& world = Stage(*game);
  world.grid.Fill(0, 0, world.grid.width(), 1, kGroundTopKind);
  game->Play(kNoAction);  // updates has_support_ and remembered_y_
  return game;
}

Entity& AddAt(Game& game, int kind, float x, float y) {
  return Stage(game).entities.emplace_back(Entity::Make(kind, x, y, 0, 0, 0.5F, 0.5F));
}

Entity& AddWalker(Game& game, float x, float vx) {
  Entity& walker = AddAt(game, kWalkerKind, x, 1.5F);
  walker.vx = vx;
  walker.smart = true;
  walker.image_kind = 6;
  return walker;
}

void PlayFor(Game& game, int steps, int32_t action) {
  for (int i = 0; i < steps; ++i) {
    game.Play(action);
  }
}

int CountCells(const Game& game, int kind) {
  const Grid& grid = game.world().grid;
  int count = 0;
  for (int cell = 0; cell < grid.size(); ++cell) {
    count += grid.At(cell) == kind ? 1 : 0;
  }
  return count;
}

// --- Crates.

TEST(CoinRunTest, ACrateDoesNotCarryAnAgentInsideIt) {
  const auto game = StagedFloor(4);
  AddAt(*game, kCrateKind, 5.5F, 1.5F);
  PlayFor(*game, 20, kNoAction);
  PlayFor(*game, 2, kDown);
  PlayFor(*game, 20, kNoAction);
  EXPECT_FLOAT_EQ(game->world().agent().y, kOnFloor) << "its remembered height is too low";
}

// --- Ends of the level.

TEST(CoinRunTest, CoinAndSawAtOnceStillComplete) {
  const auto game = StagedFloor();
  Stage(*game).grid.Set(5, 1, kCoinKind);
  AddAt(*game, kSawKind, 5.5F, 1.5F);
  game->Play(kNoAction);
  EXPECT_EQ(game->outcome().reward, 10);
  EXPECT_TRUE(game->outcome().level_complete);
}

TEST(CoinRunTest, SawsWalkersAndLavaEndTheLevelWithoutReward) {
  for (const int kind : {kSawKind, kWalkerKind}) {
    const auto game = StagedFloor();
    AddAt(*game, kind, 5.5F, 1.5F);
    game->Play(kNoAction);
    EXPECT_TRUE(game->outcome().done) << kind;
    EXPECT_EQ(game->outcome().reward, 0);
    EXPECT_FALSE(game->outcome().level_complete);
  }
  for (const int kind : {kLavaKind, kLavaSurfaceKind}) {
    const auto game = StagedFloor();
    Stage(*game).grid.Set(5, 1, kind);
    game->Play(kNoAction);
    EXPECT_TRUE(game->outcome().done) << kind;
  }
}

// --- Walkers.

TEST(CoinRunTest, AWalkerInsideACrateDoesNotCarryAnAgentElsewhere) {
  const auto game = StagedFloor();
  AddAt(*game, kCrateKind, 20.5F, 1.5F);
  AddWalker(*game, 20.5F, 0);
  PlayFor(*game, 3, kNoAction);
  EXPECT_FLOAT_EQ(game->world().agent().y, kOnFloor);
}

// --- Levels.

constexpr int kLevelCount = 200;

// Counts over the levels with `debug_mode`.
struct Census {
  int lava = 0;
  int crates = 0;
  int saws = 0;
  int above_floor = 0;  // ground tops
};

Census CensusOf(int32_t debug_mode) {
  Census census;
  for (int32_t seed = 0; seed < kLevelCount; ++seed) {
    const auto game = StartedGame("coinrun", seed, {.debug_mode = debug_mode});
    census.lava += CountCells(*game, kLavaKind) + CountCells(*game, kLavaSurfaceKind);
    census.crates += CountEntities(*game, kCrateKind);
    census.saws += CountEntities(*game, kSawKind);
    const Grid& grid = game->world().grid;
    for (int cell = grid.width(); cell < grid.size(); ++cell) {
      census.above_floor += grid.At(cell) == kGroundTopKind ? 1 : 0;
    }
  }
  return census;
}

TEST(CoinRunTest, DebugBitsRemovePitsCratesAndSteps) {
  const Census all = CensusOf(0);
  EXPECT_GT(all.lava, 0);
  EXPECT_GT(all.crates, 0);
  EXPECT_GT(all.above_floor, 0);
  EXPECT_EQ(CensusOf(2).lava, 0);
  EXPECT_GT(CensusOf(2).crates, 0);
  EXPECT_EQ(CensusOf(4).crates, 0);
  EXPECT_GT(CensusOf(4).saws, 0);
  EXPECT_EQ(CensusOf(8).above_floor, 0);
  EXPECT_EQ(CensusOf(8).lava, 0) << "flat ground has no pits either";
}

TEST(CoinRunTest, OtherDebugBitsChangeNothing) {
  for (int32_t seed = 0; seed < 20; ++seed) {
    EXPECT_EQ(StateOf(*StartedGame("coinrun", seed, {.debug_mode = 1 | 16 | 64})),
              StateOf(*StartedGame("coinrun", seed)));
  }
}

}  // namespace
}  // namespace procgen
