#ifndef TESTS_ENVCORE_WORLD_SCRIPTED_RULES_H_
#define TESTS_ENVCORE_WORLD_SCRIPTED_RULES_H_

#include <functional>
#include <string>
#include <vector>

#include "envcore/world/kinds.h"
#include "envcore/world/rules.h"
#include "envcore/world/world.h"

namespace procgen {

// Rules with answers set by a test, and a log of the queries. By default walls and the outside of
// the world block as cells, and entities neither block nor reflect.
class ScriptedRules : public Rules {
 public:
  struct Question {
    int kind;
    Axis axis;
  };

  std::function<bool(int kind, Axis axis)> cell_blocks = [](int kind, Axis /*axis*/) {
    return kind == kWallKind || kind == kOutsideKind;
  };
  std::function<bool(int kind)> reflects = [](int /*kind*/) { return false; };
  std::function<bool(const Entity& other)> entity_blocks = [](const Entity& /*other*/) {
    return false;
  };
  std::function<void(Entity& mover)> on_stopped_by_cell = [](Entity& /*mover*/) {};
  std::function<void(Entity& other)> on_agent_contact = [](Entity& /*other*/) {};
  std::function<void(Entity& self, Entity& other)> on_entity_contact = [](Entity& /*self*/,
                                                                          Entity& /*other*/) {};
  std::function<void(Entity& entity, int kind, int x, int y)> on_cell_contact =
      [](Entity& /*entity*/, int /*kind*/, int /*x*/, int /*y*/) {};

  std::vector<Question> cell_questions;  // of Blocks, in order
  int reflect_question_count = 0;
  int entity_question_count = 0;

  bool Blocks(const Entity& /*mover*/, int kind, Axis axis) override {
    cell_questions.push_back({kind, axis});
    return cell_blocks(kind, axis);
  }
  bool Reflects(const Entity& /*mover*/, int kind) override {
    ++reflect_question_count;
    return reflects(kind);
  }
  bool EntityBlocks(const Entity& /*mover*/, const Entity& other, Axis /*axis*/) override {
    ++entity_question_count;
    return entity_blocks(other);
  }
  void OnStoppedByCell(Entity& mover, Axis /*axis*/) override { on_stopped_by_cell(mover); }
  void OnAgentContact(Entity& other) override { on_agent_contact(other); }
  void OnEntityContact(Entity& self, Entity& other) override { on_entity_contact(self, other); }
  void OnCellContact(Entity& entity, int kind, int x, int y) override {
    on_cell_contact(entity, kind, x, y);
  }
};

}  // namespace procgen

#endif  // TESTS_ENVCORE_WORLD_SCRIPTED_RULES_H_
