#include "tools/solver/search_heuristic.h"

#include <algorithm>

namespace procgen {
namespace {

// Actions, by their keys.
constexpr int32_t kLeftDown = 0;
constexpr int32_t kLeft = 1;
constexpr int32_t kLeftUp = 2;
constexpr int32_t kDown = 3;
constexpr int32_t kNone = 4;
constexpr int32_t kUp = 5;
constexpr int32_t kRightDown = 6;
constexpr int32_t kRight = 7;
constexpr int32_t kRightUp = 8;
constexpr int32_t kThrowAhead = 9;
constexpr int32_t kThrowUpward = 10;
constexpr int32_t kThrowUp = 11;
constexpr int32_t kThrowDownward = 12;

constexpr int32_t kSides[] = {kLeft, kDown, kUp, kRight};
constexpr int32_t kSidesAndNone[] = {kLeft, kDown, kUp, kUp, kRight, kNone};
constexpr int32_t kMoves[] = {kLeftDown, kLeft,      kLeftUp, kDown,   kNone,
                              kUp,       kRightDown, kRight,  kRightUp};
constexpr int32_t kRunsAndJumps[] = {kLeft, kRight, kLeftUp, kRightUp, kUp, kNone};
// Mostly to the right, where the goal is.
constexpr int32_t kRightwardJumps[] = {kLeft,  kLeftUp, kUp,      kNone,
                                       kRight, kRight,  kRightUp, kRightUp};
constexpr int32_t kRightwardJumpsAndThrows[] = {
    kLeft,  kLeftUp,  kUp,      kNone,       kRight,       kRight,   kRight,
    kRight, kRightUp, kRightUp, kThrowAhead, kThrowUpward, kThrowUp, kThrowDownward};

constexpr int kCoinRunClosed[] = {15, 16, 17, 18};  // ground, lava
constexpr int kCaveFlyerClosed[] = {8};             // wall
constexpr int kClimberClosed[] = {15, 16};          // rock, platforms
constexpr int kJumperClosed[] = {6, 7};             // rock, ground
constexpr int kMazeClosed[] = {51};                 // wall
constexpr int kNinjaClosed[] = {14, 20};            // fire, bricks

constexpr SearchHeuristic kHeuristics[] = {
    {.game = "caveflyer",
     .goal_kind = 1,
     .closed_kinds = kCaveFlyerClosed,
     .actions = kMoves,
     .hold_steps_max = 6,
     .burst_steps = 24,
     .places_per_cell = 1,
     .heading_count = 8,
     .period_steps = 100},
    {.game = "climber",
     .goal_kind = 1,
     .closed_kinds = kClimberClosed,
     .actions = kRunsAndJumps,
     .hold_steps_max = 8,
     .burst_steps = 24,
     .places_per_cell = 2,
     .velocity_unit = 0.5F,
     .period_steps = 50},
    {.game = "coinrun",
     .goal_kind = 1,
     .closed_kinds = kCoinRunClosed,
     .actions = kRightwardJumps,
     .hold_steps_max = 8,
     .burst_steps = 24,
     .places_per_cell = 2,
     .velocity_unit = 0.5F},
    {.game = "heist",
     .goal_kind = 9,
     .key_kind = 2,
     .lock_kind = 1,
     .closed_kinds = kMazeClosed,
     .actions = kMoves,
     .hold_steps_max = 3,
     .burst_steps = 9,
     .places_per_cell = 2},
    {.game = "jumper",
     .goal_kind = 1,
     .closed_kinds = kJumperClosed,
     .actions = kRunsAndJumps,
     .hold_steps_max = 6,
     .burst_steps = 18,
     .places_per_cell = 2,
     .velocity_unit = 0.5F},
    {.game = "leaper",
     .goal_kind = 5,
     .actions = kSidesAndNone,
     .hold_steps_max = 8,
     .burst_steps = 16,
     .places_per_cell = 1,
     .period_steps = 8},
    {.game = "maze",
     .goal_kind = 2,
     .closed_kinds = kMazeClosed,
     .actions = kSides,
     .hold_steps_max = 2,
     .burst_steps = 4},
    {.game = "ninja",
     .goal_kind = 1,
     .closed_kinds = kNinjaClosed,
     .actions = kRightwardJumpsAndThrows,
     .hold_steps_max = 6,
     .burst_steps = 24,
     .places_per_cell = 2,
     .velocity_unit = 0.5F,
     .period_steps = 100},
};

}  // namespace

absl::Span<const SearchHeuristic> SearchHeuristics() { return kHeuristics; }

const SearchHeuristic* FindSearchHeuristic(absl::string_view game) {
  const auto* heuristic =
      std::find_if(std::begin(kHeuristics), std::end(kHeuristics),
                   [game](const SearchHeuristic& known) { return known.game == game; });
  return heuristic == std::end(kHeuristics) ? nullptr : heuristic;
}

}  // namespace procgen
