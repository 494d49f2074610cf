// procgen-random-baseline: prints a table of a random agent's returns in each game. See README.md.

#include <algorithm>
#include <cstdint>
#include <iostream>
#include <string>
#include <thread>
#include <vector>

#include "absl/flags/flag.h"
#include "absl/flags/parse.h"
#include "absl/flags/usage.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "tools/game_mode.h"
#include "tools/progress.h"
#include "tools/random_baseline/random_baseline.h"

ABSL_FLAG(std::vector<std::string>, games, {}, "games to play, e.g. maze,heist; empty: all");
ABSL_FLAG(std::vector<std::string>, modes, std::vector<std::string>({"easy", "hard"}),
          "distribution modes, e.g. easy,hard");
ABSL_FLAG(int32_t, environments, 50, "environments per game, at least 1");
ABSL_FLAG(int32_t, episodes, 40, "number of episodes to count per environment, at least 1");
ABSL_FLAG(int32_t, workers, 0, "threads that step the environments; 0: one per core");
ABSL_FLAG(int64_t, seed, 0, "seed of levels and actions");

namespace procgen {
namespace {

int32_t WorkerCount() {
  const int32_t workers = absl::GetFlag(FLAGS_workers);
  return workers > 0 ? workers
                     : std::max(1, static_cast<int32_t>(std::thread::hardware_concurrency()));
}

std::vector<std::string> AllGames() {
  std::vector<std::string> names;
  for (const GameSpec& game : GameCatalog()) {
    names.emplace_back(game.name);
  }
  return names;
}

// Returns an error in the command line; empty: none.
std::string CommandError(const std::vector<char*>& arguments) {
  if (arguments.size() > 1) {
    return absl::StrCat("unexpected argument '", arguments[1], "': only flags are allowed");
  }
  if (absl::GetFlag(FLAGS_environments) < 1 || absl::GetFlag(FLAGS_episodes) < 1) {
    return absl::StrCat("--environments ", absl::GetFlag(FLAGS_environments), " --episodes ",
                        absl::GetFlag(FLAGS_episodes), ": both must be at least 1");
  }
  if (absl::GetFlag(FLAGS_workers) < 0) {
    return absl::StrCat("--workers ", absl::GetFlag(FLAGS_workers), ": must be at least 0");
  }
  return "";
}

int Fail(absl::string_view error) {
  std::cerr << "procgen-random-baseline: " << error << "\n";
  return 2;
}

int Main(const std::vector<char*>& arguments) {
  if (const std::string error = CommandError(arguments); !error.empty()) {
    return Fail(error);
  }
  std::vector<std::string> games = absl::GetFlag(FLAGS_games);
  if (games.empty()) {
    games = AllGames();
  }
  const auto game_modes = MakeGameModes(games, absl::GetFlag(FLAGS_modes), AllGames());
  if (!game_modes.ok()) {
    return Fail(game_modes.status().message());
  }
  const RandomPlay play = {.env_count = absl::GetFlag(FLAGS_environments),
                           .episodes_per_environment = absl::GetFlag(FLAGS_episodes),
                           .worker_count = WorkerCount(),
                           .seed = absl::GetFlag(FLAGS_seed)};
  const int64_t episode_count = int64_t{play.env_count} * play.episodes_per_environment;
  Progress progress(game_modes->size());
  std::string rows;
  for (const GameMode& game_mode : *game_modes) {
    const auto statistics = PlayRandomly(game_mode, play, [&](int64_t episodes_done) {
      progress.Show(game_mode.Name(), episodes_done, episode_count);
    });
    if (!statistics.ok()) {
      return Fail(statistics.status().message());
    }
    progress.Finish(game_mode.Name(), absl::StrFormat("%.2f", statistics->return_mean));
    absl::StrAppendFormat(&rows, "| %s | %s | %.2f ± %.2f | %.1f |\n", game_mode.game->name,
                          DistributionModeName(game_mode.mode), statistics->return_mean,
                          statistics->return_error, statistics->length_mean);
  }
  std::cout << "| game | mode | mean return | mean length |\n| --- | --- | --- | --- |\n" << rows;
  return 0;
}

}  // namespace
}  // namespace procgen

int main(int argc, char** argv) {
  absl::SetProgramUsageMessage(
      "Plays episodes with random actions and prints their mean returns.\n"
      "usage: procgen-random-baseline [--games NAME,...] [--modes NAME,...] [--environments N] "
      "[--episodes N] [--workers N] [--seed N]");
  return procgen::Main(absl::ParseCommandLine(argc, argv));
}
