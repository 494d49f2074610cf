#include "envcore/world/motion.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/envcore/world/drawn_world.h"
#include "tests/envcore/world/scripted_rules.h"

namespace procgen {
namespace {

using ::testing::AnyOf;
using ::testing::FloatEq;
using ::testing::FloatNear;
using ::testing::SizeIs;

constexpr int kBallKind = 8;

const Drawing kRoom = {".....",  //
                       ".....",  //
                       ".....",  //
                       ".....",  //
                       "....."};

Entity& AddBall(World& world, float x, float y, float radius = 0.5F) {
  Entity& ball = world.entities.emplace_back(Entity::Make(kBallKind, x, y, 0, 0, radius, radius));
  ball.smart = true;
  return ball;
}

TEST(MoveSmartTest, TestsCornersUntilOneBlocksAndAllForReflection) {
  World world = DrawWorld({"#.", "#."}, 1, 1);  // walls under the left corners
  ScriptedRules rules;
  rules.cell_blocks = [](int /*kind*/, Axis /*axis*/) { return true; };
  world.whole_cell_motion = true;
  MoveSmart(world, rules, world.agent());
  EXPECT_THAT(rules.cell_questions, SizeIs(2)) << "of two moves";
  EXPECT_EQ(rules.reflect_question_count, 2 * 2) << "corners over one kind are asked of together";
}

// --- Other entities.

TEST(MoveSmartTest, AfterAFarPushItMeetsTheEntitiesThere) {
  World world = DrawWorld({"..........."}, 2.0F, 0.5F, 0.25F);
  AddBall(world, 5.5F, 0.5F, 1.0F);  // where the other ball pushes the agent to
  AddBall(world, 1.75F, 0.5F, 2.5F);
  world.agent().vx = 0.01F;
  ScriptedRules rules;
  rules.entity_blocks = [](const Entity& other) { return other.kind == kBallKind; };
  MoveSmart(world, rules, world.agent());
  // Out of the large ball to 4.5, hence out of the small one to the left, into the large one and
  // out again: as often as pushes may be nested.
  EXPECT_GT(rules.entity_question_count, 2);
  EXPECT_THAT(world.agent().x, AnyOf(FloatNear(4.5F, 1e-5F), FloatNear(4.25F, 1e-5F)));
}

TEST(MoveSmartTest, MeetsEachOfManyNearbyEntities) {
  World world = DrawWorld(kRoom, 1.5F, 1.5F, 0.5F);
  constexpr int kBallCount = 40;
  for (int i = 0; i < kBallCount; ++i) {
    AddBall(world, 1.6F, 1.5F);
  }
  world.whole_cell_motion = true;
  ScriptedRules rules;
  MoveSmart(world, rules, world.agent());
  EXPECT_EQ(rules.entity_question_count, 2 * kBallCount) << "of two moves";
}

TEST(MoveSmartTest, MarkedEntitiesDoNotBlock) {
  World world = DrawWorld(kRoom, 1.5F, 1.5F, 0.5F);
  AddBall(world, 1.6F, 1.5F).marked = true;
  ScriptedRules rules;
  MoveSmart(world, rules, world.agent());
  EXPECT_EQ(rules.entity_question_count, 0);
}

TEST(MoveSmartTest, EffectsDoNotBlockAndTheirNeighboursDo) {
  World world = DrawWorld(kRoom, 1.5F, 1.5F, 0.5F);
  AddBall(world, 2.6F, 1.5F);
  for (const int kind : {kExplosionKind, kLastExplosionKind, kTrailKind}) {
    AddBall(world, 1.6F, 1.5F).kind = kind;
  }
  world.agent().vx = 0.5F;
  ScriptedRules rules;
  rules.entity_blocks = [](const Entity& other) {
    EXPECT_EQ(other.kind, kBallKind);
    return true;
  };
  MoveSmart(world, rules, world.agent());
  EXPECT_THAT(world.agent().x, FloatEq(1.6F));
}

TEST(MoveSmartTest, EntitiesAreTestedFromTheLastToTheFirst) {
  World world = DrawWorld(kRoom, 1.5F, 1.5F, 0.5F);
  AddBall(world, 1.6F, 1.5F).theme = 1;
  AddBall(world, 1.6F, 1.5F).theme = 2;
  world.whole_cell_motion = true;
  std::vector<int> asked;
  ScriptedRules rules;
  rules.entity_blocks = [&asked](const Entity& other) {
    asked.push_back(other.theme);
    return false;
  };
  MoveSmart(world, rules, world.agent());
  EXPECT_THAT(asked, testing::ElementsAre(2, 1, 2, 1)) << "of each of the two moves";
}

// A ball centered on the agent pushes by 0, so each push meets it again.
TEST(MoveSmartTest, PushesNestAtMostFiveDeep) {
  World world = DrawWorld(kRoom, 1.5F, 1.5F, 0.5F);
  AddBall(world, 1.5F, 1.5F);
  ScriptedRules rules;
  rules.entity_blocks = [](const Entity& /*other*/) { return true; };
  MoveSmart(world, rules, world.agent());
  EXPECT_EQ(rules.entity_question_count, 2 * (1 + 5)) << "both axes are blocked in one sub-step";
  EXPECT_EQ(world.agent().x, 1.5F);
}

}  // namespace
}  // namespace procgen
