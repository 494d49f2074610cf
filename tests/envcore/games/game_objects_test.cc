#include "envcore/games/game_objects.h"

#include <vector>

#include "envcore/games/game_catalog.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

std::vector<ObjectRow> ObjectsOf(absl::string_view game, const World& world, size_t row_count,
                                 int32_t* count) {
  std::vector<ObjectRow> rows(row_count, ObjectRow{.kind = 77, .x = 77});
  *count = ReadObjects(world, FindGame(game)->kinds, absl::MakeSpan(rows));
  return rows;
}

std::unique_ptr<Game> Level(absl::string_view name) {
  std::unique_ptr<Game> game = FindGame(name)->make({.distribution_mode = DistributionMode::kEasy});
  game->StartLevel(3);
  return game;
}

TEST(ObjectsTest, TheAgentIsFirstAndAGoalThatIsACellSecond) {
  const std::unique_ptr<Game> game = Level("maze");
  int32_t count = 0;
  const std::vector<ObjectRow> rows = ObjectsOf("maze", game->world(), 4, &count);
  ASSERT_EQ(count, 2);
  EXPECT_EQ(rows[0].kind, 0);
  EXPECT_EQ(rows[0].x, game->world().agent().x);
  EXPECT_EQ(rows[1].kind, 2);
  EXPECT_EQ(game->world().grid.At(static_cast<int>(rows[1].x), static_cast<int>(rows[1].y)), 2);
  EXPECT_EQ(rows[1].rx, 0.5F);
  EXPECT_EQ(rows[2].kind, -1);
  EXPECT_EQ(rows[3].x, 0);
}

TEST(ObjectsTest, GoalsThatAreEntitiesComeBeforeOtherEntities) {
  World world;
  world.grid.Reset(4, 4, kEmptyKind);
  world.grid.Set(3, 2, 9);
  for (const int kind : {0, 1, 9, 2}) {
    world.entities.push_back(Entity::Make(kind, 1, 2, 0.5F, -0.5F, 0.25F, 0.125F));
  }
  world.entities[1].theme = 2;
  int32_t count = 0;
  const std::vector<ObjectRow> rows = ObjectsOf("heist", world, 8, &count);
  ASSERT_EQ(count, 5);
  const int kinds[] = {0, 9, 9, 1, 2};
  for (size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(rows[i].kind, static_cast<float>(kinds[i])) << i;
  }
  EXPECT_EQ(rows[2].x, 3.5F);
  EXPECT_EQ(rows[2].y, 2.5F);
  EXPECT_EQ(rows[3].theme, 2);
  EXPECT_EQ(rows[3].vx, 0.5F);
  EXPECT_EQ(rows[3].vy, -0.5F);
  EXPECT_EQ(rows[3].rx, 0.25F);
  EXPECT_EQ(rows[3].ry, 0.125F);
  EXPECT_EQ(rows[3].health, 1);
}

TEST(ObjectsTest, DisplaysOnTheScreenAreLeftOut) {
  World world;
  world.grid.Reset(4, 4, kEmptyKind);
  world.entities.assign(3, Entity());
  world.entities[1].screen_coordinates = true;
  int32_t count = 0;
  ObjectsOf("heist", world, 8, &count);
  EXPECT_EQ(count, 2);
}

TEST(ObjectsTest, TheCountCanExceedTheRows) {
  const std::unique_ptr<Game> game = Level("coinrun");
  int32_t all_count = 0;
  const std::vector<ObjectRow> all = ObjectsOf("coinrun", game->world(), 500, &all_count);
  ASSERT_GT(all_count, 3);
  int32_t count = 0;
  const std::vector<ObjectRow> rows = ObjectsOf("coinrun", game->world(), 2, &count);
  EXPECT_EQ(count, all_count);
  EXPECT_EQ(rows[1].x, all[1].x);
}

}  // namespace
}  // namespace procgen
