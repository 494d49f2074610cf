// procgen-benchmark-start: time from the start of a server process to the first observation.
// README.md in this folder describes the counters.
#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "benchmark/benchmark.h"
#include "envcore/games/game_catalog.h"
#include "procgen_client/servers.h"
#include "tests/benchmark/measuring/benchmark_run.h"
#include "tests/benchmark/measuring/time_now.h"
#include "tests/service/server_process.h"

namespace procgen {
namespace {

constexpr int kEnvCount = 64;
constexpr int kStartCount = 5;

// Starts a server, creates a pool of `game` and requests its first observations.
absl::Status SeeFirstObservation(const std::string& game) {
  ServerProcess server({"--address=127.0.0.1:0", "--log_level=error"});
  const auto servers = procgen_client::Servers::Connect(server.Address());
  if (!servers.ok()) {
    return servers.status();
  }
  PoolOptions options;
  options.games = {game};
  options.env_count = kEnvCount;
  const auto pool = procgen_client::CreatePool(*servers, options);
  if (!pool.ok()) {
    return pool.status();
  }
  std::vector<uint8_t> observations(static_cast<size_t>(kEnvCount) * kObservationBytes);
  Batch batch;
  batch.observations = absl::MakeSpan(observations);
  return (*pool)->Step({.count = kEnvCount, .steps = false}, {}, batch);
}

void RunCase(const std::string& game, benchmark::State& state) {
  absl::Duration best = absl::InfiniteDuration();
  absl::Status status;
  for ([[maybe_unused]] const auto iteration : state) {
    const absl::Duration start = TimeNow(TimeKind::kWall);
    status.Update(SeeFirstObservation(game));
    best = std::min(best, TimeNow(TimeKind::kWall) - start);
  }
  if (!status.ok()) {
    state.SkipWithError(status.ToString().c_str());
  }
  state.counters["seconds"] = absl::ToDoubleSeconds(best);
}

void RegisterCases() {
  for (const GameSpec& game : GameCatalog()) {
    const std::string name = absl::StrCat("start/", game.name, "/environments:", kEnvCount);
    benchmark::RegisterBenchmark(
        name.c_str(), [&game](benchmark::State& state) { RunCase(std::string(game.name), state); })
        ->Iterations(kStartCount)
        ->Unit(benchmark::kMillisecond);
  }
}

}  // namespace
}  // namespace procgen

int main(int argc, char** argv) {
  return procgen::RunBenchmarks(argc, argv, 0, procgen::RegisterCases);
}
