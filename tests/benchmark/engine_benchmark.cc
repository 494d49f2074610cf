// procgen-benchmark-engine: cost of a step in process, per game and mode, with and without drawing,
// with one and two workers, with the built-in art and with that of --art_dir. README.md in this
// folder describes the counters.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <iomanip>
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/flags/flag.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "benchmark/benchmark.h"
#include "envcore/games/game_catalog.h"
#include "envcore/pool/shared_art.h"
#include "tests/benchmark/learners/local_learner.h"
#include "tests/benchmark/measuring/benchmark_run.h"
#include "tests/benchmark/measuring/round_clock.h"
#include "tests/benchmark/measuring/upstream_costs.h"

ABSL_FLAG(std::string, art_dir, "",
          "folder with art in the layout of Procgen 0.10.7; empty: the built-in art only");

namespace procgen {
namespace {

// Seven rounds, as Procgen 0.10.7 was measured.
constexpr double kMinTimeSeconds = 2.1;

// The part of a benchmark's name that follows the game.
std::string GroupOf(const LocalCase& local_case) {
  const char* art = local_case.art == nullptr ? "built-in" : "art_dir";
  return absl::StrCat(DistributionModeName(local_case.mode), "/workers:", local_case.worker_count,
                      "/drawn:", local_case.drawn ? 1 : 0,
                      local_case.drawn ? absl::StrCat("/art:", art) : "");
}

struct StepCost {
  double yardstick_units;
  // Absent without drawing: upstream always draws.
  std::optional<double> upstream_ratio;
};

// Costs of one environment step, by group and game.
std::map<std::string, std::map<std::string, StepCost>>& AllCosts() {
  static auto& costs = *new std::map<std::string, std::map<std::string, StepCost>>;
  return costs;
}

void Report(const LocalCase& local_case, const RoundClock& clock, benchmark::State& state) {
  StepCost cost = {clock.BestInUnits() / LocalLearner::kEnvCount, std::nullopt};
  state.counters["yardstick_units"] = cost.yardstick_units;
  if (const auto upstream_cost = UpstreamCost(local_case.game, local_case.mode);
      upstream_cost && local_case.drawn) {
    cost.upstream_ratio = cost.yardstick_units / *upstream_cost;
    state.counters["upstream_ratio"] = *cost.upstream_ratio;
  }
  state.counters["items_per_second"] =
      LocalLearner::kEnvCount / absl::ToDoubleSeconds(clock.Best());
  AllCosts()[GroupOf(local_case)][local_case.game] = cost;
}

void RunCase(const LocalCase& local_case, benchmark::State& state) {
  absl::StatusOr<LocalLearner> learner = LocalLearner::Start(local_case);
  absl::Status status = learner.status();
  // One worker is the calling thread: its CPU time is independent of other load.
  RoundClock clock(local_case.worker_count == 1 ? TimeKind::kThread : TimeKind::kWall);
  clock.Start();
  for ([[maybe_unused]] const auto iteration : state) {
    if (!status.ok()) {
      state.SkipWithError(status.ToString().c_str());
      break;
    }
    status = learner->Step();
    if (clock.Lap()) {
      state.PauseTiming();
      clock.MeasureUnit();
      state.ResumeTiming();
      clock.Start();
    }
  }
  if (status.ok()) {
    clock.MeasureUnit();
    Report(local_case, clock, state);
  }
}

// Returns the art of the flag --art_dir; null without the flag. Ends the program with status 2 and
// a message if the art cannot be loaded.
std::shared_ptr<const SharedArt> ArtOfFlag() {
  const std::string folder = absl::GetFlag(FLAGS_art_dir);
  if (folder.empty()) {
    return nullptr;
  }
  auto art = SharedArt::LoadFolder(folder);
  if (!art.ok()) {
    std::cerr << "--art_dir: " << art.status().message() << "\n";
    std::exit(2);
  }
  return *std::move(art);
}

void RegisterCase(const LocalCase& local_case) {
  benchmark::RegisterBenchmark(
      absl::StrCat("step/", local_case.game, "/", GroupOf(local_case)).c_str(),
      [local_case](benchmark::State& state) { RunCase(local_case, state); });
}

void RegisterCases() {
  const std::shared_ptr<const SharedArt> art = ArtOfFlag();
  for (const GameSpec& game : GameCatalog()) {
    for (const DistributionMode mode : {DistributionMode::kEasy, DistributionMode::kHard}) {
      for (const int worker_count : {1, 2}) {
        LocalCase local_case = {std::string(game.name), mode, worker_count, /*drawn=*/false};
        RegisterCase(local_case);
        local_case.drawn = true;
        RegisterCase(local_case);
        if (art != nullptr) {
          local_case.art = art;
          RegisterCase(local_case);
        }
      }
    }
  }
}

// Prints to standard error: standard output may be JSON.
void PrintMeans() {
  std::cerr << "\n"
            << std::left << std::setw(38) << "geometric means of one step"
            << "games  yardstick_units  upstream_ratio  highest\n"
            << std::fixed << std::setprecision(3);
  for (const auto& [group, cost_of] : AllCosts()) {
    double units_log = 0;
    double ratio_log = 0;
    std::pair<double, std::string> highest;
    for (const auto& [game, cost] : cost_of) {
      units_log += std::log(cost.yardstick_units);
      if (cost.upstream_ratio) {
        ratio_log += std::log(*cost.upstream_ratio);
        highest = std::max(highest, {*cost.upstream_ratio, game});
      }
    }
    const auto count = static_cast<double>(cost_of.size());
    std::cerr << std::left << std::setw(38) << group << std::right << std::setw(5) << cost_of.size()
              << std::setw(17) << std::exp(units_log / count);
    if (highest.first > 0) {
      std::cerr << std::setw(16) << std::exp(ratio_log / count) << "  " << highest.first << " "
                << highest.second;
    }
    std::cerr << "\n";
  }
}

}  // namespace
}  // namespace procgen

int main(int argc, char** argv) {
  const int status =
      procgen::RunBenchmarks(argc, argv, procgen::kMinTimeSeconds, procgen::RegisterCases);
  if (status == 0) {
    procgen::PrintMeans();
  }
  return status;
}
