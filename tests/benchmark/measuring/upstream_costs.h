#ifndef TESTS_BENCHMARK_MEASURING_UPSTREAM_COSTS_H_
#define TESTS_BENCHMARK_MEASURING_UPSTREAM_COSTS_H_

#include <optional>
#include <string_view>

#include "envcore/games/game_options.h"

namespace procgen {

// Returns the cost of one environment step of Procgen 0.10.7, drawing included, in units of the
// Yardstick. Absent for unknown games and for modes other than easy and hard.
// Measured once: built with -O2, one thread, batches of 64 environments, random actions, best of
// seven rounds of 0.3 s, with the unit measured in the same minutes.
std::optional<double> UpstreamCost(std::string_view game, DistributionMode mode);

}  // namespace procgen

#endif  // TESTS_BENCHMARK_MEASURING_UPSTREAM_COSTS_H_
