#include "envcore/world/motion.h"

#include <algorithm>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/envcore/world/drawn_world.h"
#include "tests/envcore/world/scripted_rules.h"

namespace procgen {
namespace {

using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::Each;
using ::testing::Field;
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

TEST(MoveSmartTest, SpeedKeepsTheFractionOfFreeSubSteps) {
  // One of four sub-steps is free before the box touches the wall.
  World world = DrawWorld({"...#", "...#", "...#"}, 2.4F, 1.5F);
  ScriptedRules rules;
  world.agent().vx = 0.5F;
  MoveSmart(world, rules, world.agent());
  EXPECT_EQ(world.agent().x, 3 - 0.4F);
  EXPECT_EQ(world.agent().vx, 0.125F);
}

TEST(MoveSmartTest, CornersAreProbedSlightlyInsideTheBox) {
  // The box extends 0.005 into the rows of the wall; the probed corner does not.
  World world = DrawWorld({"...", "..#"}, 1.5F, 1.395F);
  ScriptedRules rules;
  world.agent().vx = 0.4F;
  MoveSmart(world, rules, world.agent());
  EXPECT_FLOAT_EQ(world.agent().x, 1.9F);
}

TEST(MoveSmartTest, FastEntitiesTakeMoreSubSteps) {
  World world = DrawWorld({"......"}, 1, 0.5F);
  ScriptedRules rules;
  world.agent().vx = 2;
  MoveSmart(world, rules, world.agent());
  const auto horizontal = std::count_if(
      rules.cell_questions.begin(), rules.cell_questions.end(),
      [](const ScriptedRules::Question& asked) { return asked.axis == Axis::kHorizontal; });
  EXPECT_EQ(horizontal, 8) << "eight sub-steps";
  EXPECT_EQ(world.agent().x, 3);
}

TEST(MoveSmartTest, AMoveByZeroIsVertical) {
  World world = DrawWorld(kRoom, 2.5F, 2.5F);
  ScriptedRules rules;
  MoveSmart(world, rules, world.agent());
  EXPECT_THAT(rules.cell_questions,
              AllOf(SizeIs(2), Each(Field(&ScriptedRules::Question::axis, Axis::kVertical))))
      << "after one sub-step without effect the others are skipped";
}

TEST(MoveSmartTest, AnEntityBlockedOnBothAxesStopsAtOnce) {
  World world = DrawWorld(kRoom, 2.5F, 2.5F);
  ScriptedRules rules;
  rules.cell_blocks = [](int /*kind*/, Axis /*axis*/) { return true; };
  world.agent().vx = 0.1F;
  world.agent().vy = 0.1F;
  MoveSmart(world, rules, world.agent());
  EXPECT_THAT(rules.cell_questions, SizeIs(2)) << "each move asks until one corner blocks";
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

TEST(MoveSmartTest, TheVelocityAfterAStopAppliesToTheRestOfThePath) {
  World world = DrawWorld(kRoom, 0.5F, 0.5F);
  world.grid.Set(3, 2, kWallKind);
  Entity& ball = AddBall(world, 2.25F, 2.5F);
  ball.vx = 1;
  ball.vy = 0.25F;
  int stops = 0;
  ScriptedRules rules;
  rules.on_stopped_by_cell = [&stops](Entity& mover) {
    mover.vx = 0;
    mover.vy = 0;
    ++stops;
  };
  MoveSmart(world, rules, ball);
  EXPECT_EQ(ball.x, 2.5F) << "flush with the wall, which it meets in its second sub-step";
  EXPECT_EQ(ball.y, 2.5F + 0.25F / 4) << "the way of its first sub-step";
  EXPECT_EQ(ball.vx, 0);
  EXPECT_EQ(ball.vy, 0);
  EXPECT_EQ(stops, 1);
}

// --- The order of the axes.

TEST(MoveSmartTest, ADiagonalAtACornerTurnsUpFirst) {
  // Right first would run into the wall; up first slides past it.
  World world = DrawWorld({"...", "..#"}, 1.4F, 0.85F);
  world.controls = {.horizontal = 1, .vertical = 1, .turn = 0};
  world.agent().vx = 0.8F;
  world.agent().vy = 0.8F;
  ScriptedRules rules;
  rules.cell_blocks = [](int kind, Axis axis) {
    return kind == kWallKind && axis == Axis::kHorizontal;
  };
  MoveSmart(world, rules, world.agent());
  EXPECT_THAT(world.agent().y, FloatNear(1.65F, 1e-5F));
  EXPECT_THAT(world.agent().x, FloatNear(2.0F, 1e-5F))
      << "two of four moves to the right were free";
}

// --- Reflection.

TEST(MoveSmartTest, BlockedAndReflectedIsReflectedAndLosesTheSpeedOfOneSubStep) {
  World world = DrawWorld({"...#"}, 0.5F, 0.5F);
  Entity& ball = AddBall(world, 2.4F, 0.5F, 0.4F);
  ball.vx = 0.5F;
  ScriptedRules rules;
  rules.cell_blocks = [](int kind, Axis /*axis*/) { return kind == kWallKind; };
  rules.reflects = [](int kind) { return kind == kWallKind; };
  MoveSmart(world, rules, ball);
  EXPECT_THAT(ball.x, FloatNear(2.3F, 1e-5F));
  EXPECT_EQ(ball.vx, -0.375F);
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

TEST(MoveSmartTest, EntitiesThatOnlyTouchDoNotBlock) {
  World world = DrawWorld(kRoom, 1.5F, 1.5F, 0.5F);
  AddBall(world, 2.4995F, 1.5F);
  ScriptedRules rules;
  MoveSmart(world, rules, world.agent());
  EXPECT_EQ(rules.entity_question_count, 0);
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
