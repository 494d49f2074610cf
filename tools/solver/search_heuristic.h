#ifndef TOOLS_SOLVER_SEARCH_HEURISTIC_H_
#define TOOLS_SOLVER_SEARCH_HEURISTIC_H_

#include <cstdint>
#include <optional>

#include "absl/strings/string_view.h"
#include "absl/types/span.h"

namespace procgen {

// The search's knowledge of a game. It determines where the search looks first and which states it
// distinguishes, never what counts as completed: that is the game's own level_complete.
struct SearchHeuristic {
  absl::string_view game;
  int goal_kind = 0;                 // of cells or entities; all of them must be reached
  std::optional<int> key_kind = {};  // of entities that must be taken first
  std::optional<int> lock_kind =
      {};  // of entities that close a cell until the key of the same theme is taken
  absl::Span<const int> closed_kinds = {};  // of cells that no path crosses
  absl::Span<const int32_t> actions =
      {};                       // to draw from; an action listed twice is twice as likely
  int32_t hold_steps_max = 1;   // an action is held for 1 to this many steps
  int32_t burst_steps = 1;      // steps from one state before the search picks another
  int32_t places_per_cell = 1;  // number of places along the side of a cell
  float velocity_unit = 0;      // velocities are distinguished in this unit; 0: not at all
  int32_t heading_count = 1;    // number of headings of the agent that are distinguished
  int32_t period_steps = 0;     // times are distinguished in this unit; 0: not at all
};

// The heuristics, sorted by game: one for each game whose levels are completed by reaching goals.
absl::Span<const SearchHeuristic> SearchHeuristics();

// Returns the heuristic of a game, or null.
const SearchHeuristic* FindSearchHeuristic(absl::string_view game);

}  // namespace procgen

#endif  // TOOLS_SOLVER_SEARCH_HEURISTIC_H_
