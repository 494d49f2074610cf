#ifndef TOOLS_SOLVER_GOAL_MAP_H_
#define TOOLS_SOLVER_GOAL_MAP_H_

#include <cstdint>
#include <map>
#include <tuple>
#include <vector>

#include "envcore/world/world.h"
#include "tools/solver/search_heuristic.h"

namespace procgen {

// The distance from the agent to completing its level.
struct GoalDistance {
  int32_t targets_left = 0;  // remaining goals and keys
  int32_t cells = 0;         // to the nearest target, over open cells, horizontally and vertically
  bool has_way = true;       // false: no target is reachable; `cells` is then the size of the grid
};

// Computes distances to the targets of a heuristic in one level. Caches a map for each set of
// remaining targets and closed locks. Threads: compatible (one thread at a time).
class GoalMap {
 public:
  // `heuristic` must outlive the map.
  explicit GoalMap(const SearchHeuristic& heuristic) : heuristic_(heuristic) {}

  // Returns the distance to the nearest goal or, if locks close every path, to the nearest
  // reachable key.
  // REQUIRES: `world` is always of the same level.
  GoalDistance From(const World& world);

 private:
  // The remaining targets and their cells, by index: the maps depend on the cells.
  struct Targets {
    int32_t count = 0;  // number of goals and keys
    std::vector<int32_t> goals;
    std::vector<int32_t> keys;
    std::vector<int32_t> closed_locks;

    bool operator<(const Targets& other) const {
      return std::tie(goals, keys, closed_locks) <
             std::tie(other.goals, other.keys, other.closed_locks);
    }
  };
  struct Maps {
    std::vector<int32_t> to_goals;  // path length in cells  [height, width]; -1: no path
    std::vector<int32_t> to_keys;
  };

  Targets TargetsIn(const World& world) const;
  // Whether a lock of `theme` is closed: its key has not been taken.
  bool IsShut(const World& world, int theme) const;
  std::vector<int32_t> MakeMap(const World& world, const std::vector<int32_t>& targets,
                               const std::vector<int32_t>& closed_locks) const;
  bool IsClosed(int kind) const;

  const SearchHeuristic& heuristic_;
  std::map<Targets, Maps> maps_;
};

}  // namespace procgen

#endif  // TOOLS_SOLVER_GOAL_MAP_H_
