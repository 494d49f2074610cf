#include "envcore/world/contacts.h"

#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/envcore/world/drawn_world.h"
#include "tests/envcore/world/scripted_rules.h"

namespace procgen {
namespace {

using ::testing::ElementsAre;
using ::testing::SizeIs;

constexpr int kBallKind = 8;

const Drawing kEmptyRoom = {"....", "....", "....", "...."};

// Adds a ball on the agent, with `name` as its theme.
Entity& AddBall(World& world, int name) {
  Entity& ball = world.entities.emplace_back(
      Entity::Make(kBallKind, world.agent().x, world.agent().y, 0, 0, 0.5F, 0.5F));
  ball.theme = name;
  return ball;
}

// Rules that log contacts: "agent-2", "1-2" for entities, "cell(x,y)".
class ContactsTest : public testing::Test {
 protected:
  ContactsTest() {
    rules_.on_agent_contact = [this](Entity& other) {
      log_.push_back("agent-" + std::to_string(other.theme));
    };
    rules_.on_entity_contact = [this](Entity& self, Entity& other) {
      log_.push_back(std::to_string(self.theme) + "-" + std::to_string(other.theme));
    };
    rules_.on_cell_contact = [this](Entity& /*entity*/, int kind, int x, int y) {
      log_.push_back("cell(" + std::to_string(x) + "," + std::to_string(y) + ")");
      kinds_.push_back(kind);
    };
  }

  ScriptedRules rules_;
  std::vector<std::string> log_;
  std::vector<int> kinds_;  // of the cells that were touched
};

TEST_F(ContactsTest, EachMeetsTheAgentThenEntitiesThenCells) {
  World world = DrawWorld({"....", ".#..", "....", "...."}, 1.5F, 2.5F);
  world.agent().smart = false;
  AddBall(world, 1);
  Entity& active = AddBall(world, 2);
  active.meets_entities = true;
  active.smart = true;
  active.rx = 0.4F;
  active.ry = 0.4F;
  MeetAll(world, rules_);
  EXPECT_THAT(log_, ElementsAre("agent-2", "2-1", "2-0", "cell(1,2)", "agent-1"));
}

TEST_F(ContactsTest, TheAgentMeetsMarkedEntitiesAndEntitiesDoNot) {
  World world = DrawWorld(kEmptyRoom, 1.5F, 1.5F);
  AddBall(world, 1).marked = true;
  AddBall(world, 2).meets_entities = true;
  MeetAll(world, rules_);
  EXPECT_THAT(log_, ElementsAre("agent-2", "2-0", "agent-1"));
}

TEST_F(ContactsTest, AnEntityMarkedByAContactMeetsNoFurtherEntity) {
  World world = DrawWorld(kEmptyRoom, 1.5F, 1.5F);
  AddBall(world, 1);
  AddBall(world, 2);
  AddBall(world, 3).meets_entities = true;
  rules_.on_agent_contact = [](Entity& /*other*/) {};
  rules_.on_entity_contact = [this](Entity& self, Entity& other) {
    log_.push_back(std::to_string(self.theme) + "-" + std::to_string(other.theme));
    self.marked = true;
  };
  MeetAll(world, rules_);
  EXPECT_THAT(log_, ElementsAre("3-2"));
}

TEST_F(ContactsTest, TheEntitysOwnMarginCounts) {
  World world = DrawWorld(kEmptyRoom, 1, 1);
  Entity& near = AddBall(world, 1);
  near.x = 2;
  near.contact_margin = 0.2F;
  Entity& nearer = AddBall(world, 2);
  nearer.x = 1.95F;
  MeetAll(world, rules_);
  EXPECT_THAT(log_, ElementsAre("agent-1"));
}

TEST_F(ContactsTest, AddedEntitiesAreNotVisitedButCanBePartners) {
  World world = DrawWorld(kEmptyRoom, 1.5F, 1.5F);
  world.entities.reserve(8);  // the rules below hold a reference while they add
  AddBall(world, 1).meets_entities = true;
  AddBall(world, 2);
  rules_.on_agent_contact = [this, &world](Entity& other) {
    log_.push_back("agent-" + std::to_string(other.theme));
    if (other.theme == 2) {
      AddBall(world, 9).meets_entities = true;
    }
  };
  MeetAll(world, rules_);
  EXPECT_THAT(log_, ElementsAre("agent-2", "agent-1", "1-9", "1-2", "1-0"));
}

TEST_F(ContactsTest, ChangesByTheAgentsContactAffectTheEntitysOtherContacts) {
  World world = DrawWorld(kEmptyRoom, 1.5F, 1.5F);
  AddBall(world, 1);
  AddBall(world, 2).meets_entities = true;
  rules_.on_agent_contact = [this](Entity& other) {
    log_.push_back("agent-" + std::to_string(other.theme));
    other.meets_entities = !other.meets_entities;
  };
  MeetAll(world, rules_);
  EXPECT_THAT(log_, ElementsAre("agent-2", "agent-1", "1-2", "1-0"));
}

TEST_F(ContactsTest, CellsAreMetColumnByColumnFromBelowAndEmptyOnesAreNot) {
  World world = DrawWorld({"###.",  //
                           "##.#",  //
                           "####",  //
                           "...."},
                          1.5F, 2, 0.8F);
  MeetAll(world, rules_);
  EXPECT_THAT(log_, ElementsAre("cell(0,1)", "cell(0,2)", "cell(1,1)", "cell(1,2)", "cell(2,1)"));
}

TEST_F(ContactsTest, HalfACellLeftOfTheWorldStillCountsAsColumnZero) {
  World world = DrawWorld({"#...", "#..."}, 0.1F, 0.5F, 0.4F);
  MeetAll(world, rules_);
  EXPECT_THAT(log_, ElementsAre("cell(0,0)"));
}

// --- Removal.

TEST(RemoveGoneTest, KeepsEntitiesThatMayLeaveTheWorldUnlessMarked) {
  World world = DrawWorld(kEmptyRoom, 1.5F, 1.5F);
  for (const bool marked : {false, true}) {
    Entity& ball = AddBall(world, 1);
    ball.x = -9;
    ball.auto_remove = false;
    ball.marked = marked;
  }
  RemoveGone(world);
  EXPECT_THAT(world.entities, SizeIs(2));
}

}  // namespace
}  // namespace procgen
