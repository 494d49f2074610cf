#include "envcore/games/game_variants.h"

#include <algorithm>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "envcore/games/game_catalog.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

constexpr int32_t kLevelCount = 200;

std::unique_ptr<Game> Level(absl::string_view name, Variant variant, int32_t level_seed,
                            float value = 0) {
  std::unique_ptr<Game> game = FindGame(name)->make(
      {.distribution_mode = DistributionMode::kHard, .variant = variant, .variant_value = value});
  game->StartLevel(level_seed);
  return game;
}

// The cell of the only goal.
std::pair<int, int> GoalIn(const Grid& grid, int kind) {
  std::pair<int, int> place = {-1, -1};
  int count = 0;
  for (int y = 0; y < grid.height(); ++y) {
    for (int x = 0; x < grid.width(); ++x) {
      if (grid.At(x, y) == kind) {
        place = {x, y};
        ++count;
      }
    }
  }
  EXPECT_EQ(count, 1);
  return place;
}

TEST(VariantsTest, TextsAreReadAgain) {
  GameOptions options;
  for (const VariantSpec& spec : VariantCatalog()) {
    EXPECT_EQ(FindVariant(spec.game, spec.variant), &spec);
    EXPECT_NE(FindGame(spec.game), nullptr);
    for (const float value : {spec.value, spec.value / 3}) {
      EXPECT_TRUE(SetVariant(VariantText(spec.variant, value), &options));
      EXPECT_EQ(options.variant, spec.variant);
      EXPECT_EQ(options.variant_value, value);
    }
  }
  EXPECT_EQ(VariantText(*FindVariant("jumper", Variant::kGravity)), "gravity=0.15");
  EXPECT_TRUE(SetVariant("", &options));
  EXPECT_EQ(options.variant, Variant::kNone);
  EXPECT_EQ(options.variant_value, 0);
  for (const char* text :
       {"coin_nowhere", "coin_random=1", "gravity", "gravity=", "gravity=high"}) {
    EXPECT_FALSE(SetVariant(text, &options)) << text;
  }
}

// Plays random actions in some levels with a value of a variant and without; returns the number of
// steps whose agent, enemies or reward differ.
int DifferentSteps(const VariantSpec& spec, float value) {
  int count = 0;
  for (int32_t seed = 0; seed < 20; ++seed) {
    const auto exact = Level(spec.game, Variant::kNone, seed);
    const auto varied = Level(spec.game, spec.variant, seed, value);
    EXPECT_EQ(exact->random().draws(), varied->random().draws());
    EXPECT_EQ(exact->world().entities.size(), varied->world().entities.size());
    for (int cell = 0; cell < exact->world().grid.size(); ++cell) {
      EXPECT_EQ(exact->world().grid.At(cell), varied->world().grid.At(cell));
    }
    RandomStream random(seed);
    for (int step = 0; step < 100 && !exact->outcome().done && !varied->outcome().done; ++step) {
      const int32_t action = random.Int(kActionCount);
      exact->Play(action);
      varied->Play(action);
      bool differs = exact->outcome().reward != varied->outcome().reward ||
                     exact->world().entities.size() != varied->world().entities.size();
      for (size_t i = 0; i < exact->world().entities.size() && !differs; ++i) {
        const Entity& one = exact->world().entities[i];
        const Entity& other = varied->world().entities[i];
        differs = one.x != other.x || one.y != other.y || one.vy != other.vy;
      }
      count += differs ? 1 : 0;
    }
  }
  return count;
}

TEST(VariantsTest, AValueChangesStepsOfTheSameLevelsAndUpstreamsChangesNothing) {
  for (const VariantSpec& spec : VariantCatalog()) {
    if (spec.value != 0) {
      EXPECT_EQ(DifferentSteps(spec, spec.value), 0) << spec.game << " " << spec.name;
      EXPECT_GT(DifferentSteps(spec, spec.value * 2), 100) << spec.game << " " << spec.name;
      EXPECT_GT(DifferentSteps(spec, spec.value / 2), 100) << spec.game << " " << spec.name;
    }
  }
}

TEST(VariantsTest, JumpsAreHigherWithLessGravity) {
  for (const char* name : {"climber", "coinrun", "jumper"}) {
    const float upstreams = FindVariant(name, Variant::kGravity)->value;
    std::vector<float> heights;  // sums over levels
    for (const float gravity : {upstreams * 2, upstreams, upstreams / 2}) {
      heights.push_back(0);
      for (int32_t seed = 0; seed < 20; ++seed) {
        const auto level = Level(name, Variant::kGravity, seed, gravity);
        const float start = level->world().agent().y;
        float highest = start;
        for (int step = 0; step < 15; ++step) {
          level->Play(/*action=*/5);  // up
          highest = std::max(highest, level->world().agent().y);
        }
        heights.back() += highest - start;
      }
    }
    EXPECT_LT(heights[0], heights[1]) << name;
    EXPECT_LT(heights[1], heights[2]) << name;
  }
}

TEST(VariantsTest, OnlyTheGoalMovesAndNoDrawOfTheLevelChanges) {
  for (const VariantSpec& spec : VariantCatalog()) {
    if (spec.value != 0) {
      continue;
    }
    const int goal = FindGame(spec.game)->kinds[0].kind;
    for (int32_t seed = 0; seed < kLevelCount; ++seed) {
      const auto exact = Level(spec.game, Variant::kNone, seed);
      const auto varied = Level(spec.game, spec.variant, seed);
      Grid grid = exact->world().grid;
      const Grid& changed = varied->world().grid;
      const auto [x, y] = GoalIn(grid, goal);
      const auto [to_x, to_y] = GoalIn(changed, goal);
      ASSERT_TRUE(grid.At(to_x, to_y) == kEmptyKind || grid.At(to_x, to_y) == goal);
      grid.Set(x, y, kEmptyKind);
      grid.Set(to_x, to_y, goal);
      for (int cell = 0; cell < grid.size(); ++cell) {
        ASSERT_EQ(grid.At(cell), changed.At(cell)) << spec.name << " level " << seed;
      }
      EXPECT_EQ(exact->random().draws(), varied->random().draws());
      const size_t added_count = spec.variant == Variant::kTwoObjects ? 1 : 0;
      EXPECT_EQ(exact->world().entities.size() + added_count, varied->world().entities.size());
    }
  }
}

TEST(VariantsTest, CoinsAreOnTheGroundAtDifferentPlaces) {
  std::set<int> columns;
  int at_end_count = 0;
  for (int32_t seed = 0; seed < kLevelCount; ++seed) {
    const auto exact = Level("coinrun", Variant::kNone, seed);
    const auto varied = Level("coinrun", Variant::kCoinRandom, seed);
    const Grid& grid = varied->world().grid;
    const auto [x, y] = GoalIn(grid, 1);
    EXPECT_EQ(grid.At(x, y - 1), 16) << seed;
    columns.insert(x);
    at_end_count += GoalIn(exact->world().grid, 1) == std::pair(x, y) ? 1 : 0;
    for (const Entity& entity : varied->world().entities) {
      EXPECT_FALSE(static_cast<int>(entity.x) == x && static_cast<int>(entity.y) == y) << seed;
    }
  }
  EXPECT_GT(columns.size(), 25);
  EXPECT_LT(at_end_count, kLevelCount / 4);
}

TEST(VariantsTest, CheeseIsInTheCornerOppositeToTheStart) {
  for (int32_t seed = 0; seed < kLevelCount; ++seed) {
    const auto level = Level("maze", Variant::kCheeseCorner, seed);
    const Grid& grid = level->world().grid;
    const auto [x, y] = GoalIn(grid, 2);
    EXPECT_EQ(x, grid.width() - 1 - static_cast<int>(level->world().agent().x)) << seed;
    EXPECT_EQ(y, grid.height() - 1 - static_cast<int>(level->world().agent().y)) << seed;
  }
}

TEST(VariantsTest, TheDecoyIsInAnEmptyCellAndDoesNothing) {
  std::set<std::pair<float, float>> places;
  for (int32_t seed = 0; seed < kLevelCount; ++seed) {
    const auto level = Level("maze", Variant::kTwoObjects, seed);
    const World& world = level->world();
    ASSERT_EQ(world.entities.size(), 2);
    const Entity& decoy = world.entities[1];
    EXPECT_EQ(world.CellAtPoint(decoy.x, decoy.y), kEmptyKind) << seed;
    EXPECT_FALSE(Overlap(decoy, world.agent(), 0)) << seed;
    places.insert({decoy.x, decoy.y});
    const auto exact = Level("maze", Variant::kNone, seed);
    RandomStream random(seed);
    for (int step = 0; step < 50 && !exact->outcome().done; ++step) {
      const int32_t action = random.Int(kActionCount);
      exact->Play(action);
      level->Play(action);
      ASSERT_EQ(exact->world().agent().x, level->world().agent().x) << seed;
      ASSERT_EQ(exact->outcome().reward, level->outcome().reward) << seed;
    }
  }
  EXPECT_GT(places.size(), 50);
}

}  // namespace
}  // namespace procgen
