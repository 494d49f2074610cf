#ifndef TOOLS_SOLVER_GOAL_MAP_H_
#define TOOLS_SOLVER_GOAL_MAP_H_

#include <cstdint>
#include <map>
#include <tuple>
#include <vector>

#include "envcore/world/world.h"
#include "tools/solver/guide.h"

namespace procgen {

// How far the agent is from completing its level.
struct GoalDistance {
  int32_t targets_left = 0;  // goals and keys still there
  int32_t cells = 0;         // to the next of them over open cells, from side to side
  bool has_way = true;       // false: closed cells part the agent from all of them; then `cells` is
                             // the number of cells of the grid
};

// Tells how far it is to what a guide wants, through the cells of one level. Maps are made once for
// each set of targets left and locks closed. Threads: compatible (one thread at a time).
class GoalMap {
 public:
  // `guide` must outlive it.
  explicit GoalMap(const Guide& guide) : guide_(guide) {}

  // To the nearest goal; where locks close every way, to the nearest key that can be reached.
  // REQUIRES: it is always the world of the same level.
  GoalDistance From(const World& world);

 private:
  // What there is, and in which cells, by index: the maps depend on the cells.
  struct Targets {
    int32_t count = 0;  // of goals and keys
    std::vector<int32_t> goals;
    std::vector<int32_t> keys;
    std::vector<int32_t> closed_locks;

    bool operator<(const Targets& other) const {
      return std::tie(goals, keys, closed_locks) <
             std::tie(other.goals, other.keys, other.closed_locks);
    }
  };
  struct Maps {
    std::vector<int32_t> to_goals;  // cells to go  [height, width]; -1: no way
    std::vector<int32_t> to_keys;
  };

  Targets TargetsIn(const World& world) const;
  // Whether a lock of `theme` stays shut: its key still lies about.
  bool IsShut(const World& world, int theme) const;
  std::vector<int32_t> MakeMap(const World& world, const std::vector<int32_t>& targets,
                               const std::vector<int32_t>& closed_locks) const;
  bool IsClosed(int kind) const;

  const Guide& guide_;
  std::map<Targets, Maps> maps_;
};

}  // namespace procgen

#endif  // TOOLS_SOLVER_GOAL_MAP_H_
