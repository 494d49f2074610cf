#ifndef TOOLS_SOLVER_SEARCH_H_
#define TOOLS_SOLVER_SEARCH_H_

#include <cstdint>
#include <vector>

#include "envcore/games/game_catalog.h"
#include "envcore/games/game_options.h"
#include "tools/solver/search_heuristic.h"

namespace procgen {

// The result for a level.
enum class Verdict {
  kSolved,
  kLostAtOnce,  // unsolvable: every first action loses the level
  kClosedOff,   // unsolvable: closed cells separate the agent from its goal
  kGivenUp,     // no solution was found
};

// The result of searching one level.
struct SearchResult {
  Verdict verdict = Verdict::kGivenUp;
  std::vector<int32_t> actions;  // from the first step to completion; empty if unsolved
  int64_t burst_count = 0;       // number of bursts of actions that were tried
  int64_t step_count = 0;        // total number of steps played
};

// Searches for actions that complete a level. Keeps one state per place (as the heuristic defines
// it), the one with the fewest steps. Repeatedly returns to the most promising one, tries a burst
// of random actions, each held for some steps, and keeps the new places that they lead to. A place
// is more promising the closer it is to the goal and the less often it was tried. Returns the first
// solution, which need not be short. Equal arguments give equal results. Gives up after
// `burst_count_max` bursts. `heuristic`: that of the game. REQUIRES: the game has the mode.
SearchResult SearchLevel(const GameSpec& spec, const SearchHeuristic& heuristic,
                         DistributionMode mode, int32_t level_seed, int64_t burst_count_max);

// Whether `actions`, in a new environment with this level only, complete it with their last step
// and no earlier.
bool CompletesLevel(const GameSpec& spec, DistributionMode mode, int32_t level_seed,
                    const std::vector<int32_t>& actions);

}  // namespace procgen

#endif  // TOOLS_SOLVER_SEARCH_H_
