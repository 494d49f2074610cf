#ifndef TOOLS_SOLVER_SEARCH_H_
#define TOOLS_SOLVER_SEARCH_H_

#include <cstdint>
#include <vector>

#include "envcore/games/game_catalog.h"
#include "envcore/games/game_options.h"
#include "tools/solver/guide.h"

namespace procgen {

// What is known of a level.
enum class Verdict {
  kSolved,
  kLostAtOnce,  // no way: the level is lost in its first step, whatever the action
  kClosedOff,   // no way: closed cells part the agent from its goal
  kGivenUp,     // none was found
};

// What came of searching one level.
struct SearchResult {
  Verdict verdict = Verdict::kGivenUp;
  std::vector<int32_t> actions;  // from the level's first step to its completion; none if unsolved
  int64_t burst_count = 0;       // states from which actions were tried
  int64_t step_count = 0;        // steps played in all
};

// Looks for actions that complete a level: remembers one state for each place (in the sense of the
// guide), the one with the fewest steps, goes back to the most promising one, tries a burst of
// random actions, each held for some steps, and remembers the new places that they lead to. A place
// is the more promising the closer to the goal it is and the less it was tried. The first way
// found is taken, so it need not be short. Equal arguments give equal results. Gives up after
// `burst_count_max` bursts. `guide` is the game's. REQUIRES: the game has the mode.
SearchResult SearchLevel(const GameSpec& spec, const Guide& guide, DistributionMode mode,
                         int32_t level_seed, int64_t burst_count_max);

// Whether `actions`, taken in a fresh environment that has this level alone, complete it with the
// last of them and no sooner.
bool CompletesLevel(const GameSpec& spec, DistributionMode mode, int32_t level_seed,
                    const std::vector<int32_t>& actions);

}  // namespace procgen

#endif  // TOOLS_SOLVER_SEARCH_H_
