#ifndef TOOLS_SOLVER_GUIDE_H_
#define TOOLS_SOLVER_GUIDE_H_

#include <cstdint>
#include <optional>

#include "absl/strings/string_view.h"
#include "absl/types/span.h"

namespace procgen {

// What the search knows of a game. It decides where the search looks first and what tells two
// states apart, never what counts: that is the game's own level_complete.
struct Guide {
  absl::string_view game;
  int goal_kind = 0;                        // of cells or entities; all of them are wanted
  std::optional<int> key_kind = {};         // of entities that are wanted first
  std::optional<int> lock_kind = {};        // of entities that close a cell until the key of the
                                            // same theme is taken
  absl::Span<const int> closed_kinds = {};  // of cells that no way leads through
  absl::Span<const int32_t> actions = {};   // to draw from; what is listed twice, twice as often
  int32_t hold_steps_max = 1;               // steps that an action is held: 1 ... this
  int32_t burst_steps = 1;                  // steps tried from one state before looking again
  int32_t places_per_cell = 1;              // along a side: how finely places are told apart
  float velocity_unit = 0;                  // velocities are told apart by it; 0: not at all
  int32_t heading_count = 1;                // directions of the agent that are told apart
  int32_t period_steps = 0;                 // moments so far apart are told apart; 0: not at all
};

// A guide for each game whose levels can be completed by getting somewhere, sorted by name.
absl::Span<const Guide> Guides();

// The guide for a game; null if there is none.
const Guide* FindGuide(absl::string_view game);

}  // namespace procgen

#endif  // TOOLS_SOLVER_GUIDE_H_
