#include <algorithm>
#include <cmath>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/envcore/games/staged_game.h"

namespace procgen {
namespace {

using ::testing::ElementsAre;

constexpr int kCoinKind = 1;
constexpr int kSawKind = 2;
constexpr int kWalkerKind = 5;
constexpr int kGroundKind = 15;
constexpr int kGroundTopKind = 16;
constexpr int kLavaKind = 17;
constexpr int kLavaSurfaceKind = 18;
constexpr int kBarrierKind = 19;
constexpr int kCrateKind = 20;

constexpr float kRadiusY = 0.5787F;       // of the agent
constexpr float kOnFloor = 1 + kRadiusY;  // y of an agent on row 0
constexpr float kOnCrate = 2 + kRadiusY;  // y of an agent on a crate in row 1
constexpr int32_t kDown = 3;
constexpr int32_t kJump = 5;
constexpr int32_t kRight = 7;

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

// --- Running and jumping.

TEST(CoinRunTest, SpeedAfterOneStepFromRestIsATenth) {
  const auto game = StagedFloor();
  game->Play(kRight);
  EXPECT_EQ(game->world().agent().vx, 0.1F);
}

TEST(CoinRunTest, JumpsOnlyWithSupport) {
  const auto game = StagedFloor();
  game->Play(kJump);
  EXPECT_EQ(game->world().agent().vy, 1.5F);
  game->Play(kJump);
  EXPECT_EQ(game->world().agent().vy, 1.5F - 0.2F) << "gravity only";
}

TEST(CoinRunTest, AJumpLandsWhereItStarted) {
  const auto game = StagedFloor();
  game->Play(kJump);
  PlayFor(*game, 30, kNoAction);
  EXPECT_FLOAT_EQ(game->world().agent().y, kOnFloor);
  EXPECT_EQ(game->world().agent().vy, 0);
}

// --- Crates.

TEST(CoinRunTest, StandsOnACrateAfterAFallAndJumpsFromIt) {
  const auto game = StagedFloor(4);
  AddAt(*game, kCrateKind, 5.5F, 1.5F);
  PlayFor(*game, 20, kNoAction);
  EXPECT_FLOAT_EQ(game->world().agent().y, kOnCrate);
  game->Play(kJump);
  EXPECT_EQ(game->world().agent().vy, 1.5F);
}

TEST(CoinRunTest, PressingDownFallsThroughACrate) {
  const auto game = StagedFloor(4);
  AddAt(*game, kCrateKind, 5.5F, 1.5F);
  PlayFor(*game, 20, kNoAction);
  PlayFor(*game, 20, kDown);
  EXPECT_FLOAT_EQ(game->world().agent().y, kOnFloor);
}

TEST(CoinRunTest, ACrateDoesNotCarryAnAgentInsideIt) {
  const auto game = StagedFloor(4);
  AddAt(*game, kCrateKind, 5.5F, 1.5F);
  PlayFor(*game, 20, kNoAction);
  PlayFor(*game, 2, kDown);
  PlayFor(*game, 20, kNoAction);
  EXPECT_FLOAT_EQ(game->world().agent().y, kOnFloor) << "its remembered height is too low";
}

TEST(CoinRunTest, JumpsUpThroughACrateAndLandsOnIt) {
  const auto game = StagedFloor();
  AddAt(*game, kCrateKind, 5.5F, 1.5F);
  game->Play(kJump);
  EXPECT_GT(game->world().agent().y, kOnCrate);
  PlayFor(*game, 30, kNoAction);
  EXPECT_FLOAT_EQ(game->world().agent().y, kOnCrate);
}

TEST(CoinRunTest, CratesDoNotBlockSideways) {
  const auto game = StagedFloor();
  AddAt(*game, kCrateKind, 7.5F, 1.5F);
  PlayFor(*game, 12, kRight);
  EXPECT_GT(game->world().agent().x, 8);
  EXPECT_FLOAT_EQ(game->world().agent().y, kOnFloor);
}

// --- Ends of the level.

TEST(CoinRunTest, TheCoinPaysTenAndCompletes) {
  const auto game = StagedFloor();
  Stage(*game).grid.Set(5, 1, kCoinKind);
  game->Play(kNoAction);
  EXPECT_EQ(game->outcome().reward, 10);
  EXPECT_TRUE(game->outcome().done);
  EXPECT_TRUE(game->outcome().level_complete);
}

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

TEST(CoinRunTest, CratesAndBarriersAreHarmless) {
  const auto game = StagedFloor();
  AddAt(*game, kCrateKind, 5.5F, 1.5F);
  Stage(*game).grid.Set(5, 1, kBarrierKind);
  game->Play(kNoAction);
  EXPECT_FALSE(game->outcome().done);
}

// --- Walkers.

// The speed of a walker after one contact with a cell of `kind`.
float SpeedAfterMeeting(int kind) {
  const auto game = StagedFloor();
  Stage(*game).grid.Set(12, 1, kind);
  AddWalker(*game, 11.4F, static_cast<float>(0.15));
  game->Play(kNoAction);
  return game->world().entities[1].vx;
}

TEST(CoinRunTest, WalkersKeepTheirSpeedAtBarriersAndGroundTops) {
  EXPECT_EQ(SpeedAfterMeeting(kBarrierKind), -0.15F);
  EXPECT_EQ(SpeedAfterMeeting(kGroundTopKind), -0.15F);
}

TEST(CoinRunTest, WalkersLoseAQuarterOfTheirSpeedAtGround) {
  EXPECT_EQ(SpeedAfterMeeting(kGroundKind), -0.15F * 0.75F);
}

TEST(CoinRunTest, WalkersWalkThroughTheCoin) { EXPECT_EQ(SpeedAfterMeeting(kCoinKind), 0.15F); }

TEST(CoinRunTest, WalkersRaiseDustThatIsGoneAfterNineSteps) {
  const auto game = StagedFloor();
  AddWalker(*game, 20.5F, 0);
  PlayFor(*game, 30, kNoAction);
  EXPECT_EQ(CountEntities(*game, kTrailKind), 9);
}

TEST(CoinRunTest, AWalkerInsideACrateDoesNotCarryAnAgentElsewhere) {
  const auto game = StagedFloor();
  AddAt(*game, kCrateKind, 20.5F, 1.5F);
  AddWalker(*game, 20.5F, 0);
  PlayFor(*game, 3, kNoAction);
  EXPECT_FLOAT_EQ(game->world().agent().y, kOnFloor);
}

// --- Appearance.

int AgentImage(const Game& game) {
  Scene scene;
  game.FillScene(&scene);
  const auto found = std::find_if(scene.above_cells.begin(), scene.above_cells.end(),
                                  [](const Sprite& sprite) { return sprite.art_height != 1; });
  return found == scene.above_cells.end() ? -1 : found->image_kind;
}

TEST(CoinRunTest, TheFirstFrameShowsAWalkingPose) {
  EXPECT_EQ(AgentImage(*StartedGame("coinrun", 0)), 12);
}

TEST(CoinRunTest, StandsWhenItHasSupportAndRests) {
  const auto game = StagedFloor();
  PlayFor(*game, 3, kNoAction);
  EXPECT_EQ(AgentImage(*game), 0);
}

TEST(CoinRunTest, TheWalkChangesImageEveryFiveSteps) {
  const auto game = StagedFloor();  // after one step
  std::vector<int> images;
  for (int i = 0; i < 10; ++i) {
    game->Play(kRight);
    images.push_back(AgentImage(*game));
  }
  EXPECT_THAT(images, ElementsAre(12, 12, 12, 13, 13, 13, 13, 13, 12, 12));
}

TEST(CoinRunTest, TheWholeWorldIsSeenWithoutCenterAgent) {
  const auto game = StartedGame("coinrun", 0, {.center_agent = false});
  Scene scene;
  game->FillScene(&scene);
  EXPECT_EQ(scene.camera.cells, 64);
}

TEST(CoinRunTest, BarriersAreNeverDrawn) {
  const auto game = StartedGame("coinrun", 0, {.use_monochrome_assets = true});
  Scene scene;
  game->FillScene(&scene);
  EXPECT_LT(scene.cells.looks[kBarrierKind].image_kind, 0);
}

// --- Levels.

constexpr int kLevelCount = 200;

TEST(CoinRunTest, EveryLevelHasOneCoinOnGroundAndAWallBehindIt) {
  for (int32_t seed = 0; seed < kLevelCount; ++seed) {
    const auto game = StartedGame("coinrun", seed);
    const Grid& grid = game->world().grid;
    ASSERT_EQ(CountCells(*game, kCoinKind), 1);
    int coin = 0;
    while (grid.At(coin) != kCoinKind) {
      ++coin;
    }
    EXPECT_EQ(grid.At(coin - grid.width()), kGroundTopKind);
    EXPECT_EQ(grid.At(coin + 1), kGroundKind);
  }
}

TEST(CoinRunTest, EasyLevelsLookAlikeAndHaveWalkersInPitsOnly) {
  for (int32_t seed = 0; seed < kLevelCount; ++seed) {
    const auto game = StartedGame("coinrun", seed, {.distribution_mode = DistributionMode::kEasy});
    Scene scene;
    game->FillScene(&scene);
    EXPECT_EQ(scene.background.index, 0);
    EXPECT_EQ(game->world().agent().theme, 0);
    EXPECT_EQ(scene.cells.looks[kGroundKind].theme, 0);
    for (const Entity& entity : game->world().entities) {
      EXPECT_TRUE(entity.kind != kWalkerKind || entity.y == 1.5F);
    }
  }
}

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
    EXPECT_EQ(DigestOf(*StartedGame("coinrun", seed, {.debug_mode = 1 | 16 | 64})),
              DigestOf(*StartedGame("coinrun", seed)));
  }
}

}  // namespace
}  // namespace procgen
