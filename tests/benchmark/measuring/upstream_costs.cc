#include "tests/benchmark/measuring/upstream_costs.h"

namespace procgen {
namespace {

struct GameCosts {
  std::string_view game;
  double easy;
  double hard;
};

constexpr GameCosts kCosts[] = {
    {"bigfish", 1.60, 1.58},   {"bossfight", 12.08, 9.35}, {"caveflyer", 3.91, 6.58},
    {"chaser", 2.93, 3.42},    {"climber", 3.93, 4.88},    {"coinrun", 5.69, 7.12},
    {"dodgeball", 3.12, 3.74}, {"fruitbot", 4.46, 8.99},   {"heist", 2.57, 3.79},
    {"jumper", 6.88, 7.97},    {"leaper", 2.88, 4.19},     {"maze", 4.21, 8.73},
    {"miner", 3.17, 8.92},     {"ninja", 3.60, 6.24},      {"plunder", 1.78, 1.80},
    {"starpilot", 2.30, 2.26},
};

}  // namespace

std::optional<double> UpstreamCost(std::string_view game, DistributionMode mode) {
  if (mode != DistributionMode::kEasy && mode != DistributionMode::kHard) {
    return std::nullopt;
  }
  for (const GameCosts& costs : kCosts) {
    if (costs.game == game) {
      return mode == DistributionMode::kEasy ? costs.easy : costs.hard;
    }
  }
  return std::nullopt;
}

}  // namespace procgen
