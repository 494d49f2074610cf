// procgen-solve: searches for a solution of each of many levels, verifies it by playing it again,
// and reports the unsolved levels. See README.md.

#include <atomic>
#include <cstdint>
#include <fstream>
#include <iostream>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/flags/flag.h"
#include "absl/flags/parse.h"
#include "absl/flags/usage.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "tools/progress.h"
#include "tools/solver/search.h"
#include "tools/solver/search_heuristic.h"

ABSL_FLAG(std::vector<std::string>, games, {},
          "games to search, e.g. maze,heist; empty: all games with a heuristic");
ABSL_FLAG(std::vector<std::string>, modes, {"easy"}, "distribution modes, e.g. easy,hard");
ABSL_FLAG(int32_t, first_level, 0, "seed of the first level, at least 0");
ABSL_FLAG(int32_t, levels, 200, "number of levels, at least 1, with consecutive seeds");
ABSL_FLAG(int32_t, workers, 2, "search threads, at least 1; each searches one level at a time");
ABSL_FLAG(int64_t, bursts, 100000,
          "bursts of random actions per level before it is given up, at least 1");
ABSL_FLAG(std::string, ways, "",
          "output file for the solutions, one line per solved level: game, mode, seed, actions");

namespace procgen {
namespace {

struct GameMode {
  const GameSpec* game = nullptr;
  DistributionMode mode = DistributionMode::kEasy;

  // "maze easy".
  std::string Name() const { return absl::StrCat(game->name, " ", DistributionModeName(mode)); }
};

// The levels of one game and mode, and their results. Threads: Search from any thread.
class Levels {
 public:
  Levels(const GameMode& game_mode, int32_t first_level, int32_t level_count, Progress& progress)
      : game_mode_(game_mode),
        first_level_(first_level),
        level_count_(level_count),
        results_(static_cast<size_t>(level_count)),
        progress_(progress) {}

  // Searches levels until all are taken.
  void Search(int64_t burst_count_max) {
    const SearchHeuristic& heuristic = *FindSearchHeuristic(game_mode_.game->name);
    for (int32_t i = next_++; i < level_count_; i = next_++) {
      const int32_t seed = first_level_ + i;
      SearchResult result =
          SearchLevel(*game_mode_.game, heuristic, game_mode_.mode, seed, burst_count_max);
      if (result.verdict == Verdict::kSolved &&
          !CompletesLevel(*game_mode_.game, game_mode_.mode, seed, result.actions)) {
        has_invalid_solution_ = true;
      }
      results_[static_cast<size_t>(i)] = std::move(result);
      const absl::MutexLock lock(&progress_mutex_);
      progress_.Show(game_mode_.Name(), ++done_count_, level_count_);
    }
  }

  const GameMode& game_mode() const { return game_mode_; }
  const std::vector<SearchResult>& results() const { return results_; }
  const SearchResult& ResultOf(int32_t seed) const {
    return results_[static_cast<size_t>(seed - first_level_)];
  }
  // The seeds of the levels with this verdict.
  std::vector<int32_t> SeedsOf(Verdict verdict) const {
    std::vector<int32_t> seeds;
    for (size_t i = 0; i < results_.size(); ++i) {
      if (results_[i].verdict == verdict) {
        seeds.push_back(first_level_ + static_cast<int32_t>(i));
      }
    }
    return seeds;
  }
  // Whether a solution did not complete its level when it was played again.
  bool has_invalid_solution() const { return has_invalid_solution_; }

 private:
  const GameMode game_mode_;
  const int32_t first_level_;
  const int32_t level_count_;
  std::atomic<int32_t> next_ = 0;
  std::vector<SearchResult> results_;  // each written by the thread that took the level
  std::atomic<bool> has_invalid_solution_ = false;
  absl::Mutex progress_mutex_;
  int32_t done_count_ ABSL_GUARDED_BY(progress_mutex_) = 0;
  Progress& progress_;
};

// The printed summary of one game and mode.
struct Summary {
  std::string row;                 // of the table
  std::vector<std::string> notes;  // about unsolved levels
  bool good = true;                // every level was solved and verified, or is unsolvable
};

std::string MeanLength(const Levels& levels, size_t solved_count) {
  if (solved_count == 0) {
    return "-";
  }
  size_t length_sum = 0;
  for (const SearchResult& result : levels.results()) {
    length_sum += result.actions.size();
  }
  return absl::StrFormat("%.1f",
                         static_cast<double>(length_sum) / static_cast<double>(solved_count));
}

Summary Summarize(const Levels& levels, absl::Duration time) {
  Summary summary;
  int64_t burst_count = 0;
  int64_t step_count = 0;
  for (const SearchResult& result : levels.results()) {
    burst_count += result.burst_count;
    step_count += result.step_count;
  }
  struct Note {
    Verdict verdict;
    absl::string_view text;
  };
  constexpr Note kNotes[] = {
      {Verdict::kLostAtOnce, "unsolvable: lost in the first step with every action"},
      {Verdict::kClosedOff, "unsolvable: closed cells separate the agent from the goal"},
      {Verdict::kGivenUp, "given up"}};
  for (const Note& note : kNotes) {
    const std::vector<int32_t> seeds = levels.SeedsOf(note.verdict);
    if (!seeds.empty()) {
      summary.notes.push_back(absl::StrCat(levels.game_mode().Name(), ": ", note.text, ": ",
                                           absl::StrJoin(seeds, ", ")));
    }
  }
  const size_t level_count = levels.results().size();
  const size_t solved_count = levels.SeedsOf(Verdict::kSolved).size();
  const size_t given_up_count = levels.SeedsOf(Verdict::kGivenUp).size();
  summary.row = absl::StrFormat(
      "| %s | %s | %d of %d | %d | %d | %s | %d | %d | %.1f |", levels.game_mode().game->name,
      DistributionModeName(levels.game_mode().mode), solved_count, level_count,
      level_count - solved_count - given_up_count, given_up_count, MeanLength(levels, solved_count),
      burst_count, step_count, absl::ToDoubleSeconds(time));
  summary.good = given_up_count == 0 && !levels.has_invalid_solution();
  if (levels.has_invalid_solution()) {
    summary.notes.push_back(absl::StrCat(
        levels.game_mode().Name(), ": a solution does not complete its level, which is a bug"));
  }
  return summary;
}

void WriteWays(const Levels& levels, std::ostream& file) {
  for (const int32_t seed : levels.SeedsOf(Verdict::kSolved)) {
    file << levels.game_mode().Name() << " " << seed << ": "
         << absl::StrJoin(levels.ResultOf(seed).actions, ",") << "\n";
  }
}

Summary RunGameMode(const GameMode& game_mode, Progress& progress, std::ostream& ways) {
  const absl::Time begin = absl::Now();
  Levels levels(game_mode, absl::GetFlag(FLAGS_first_level), absl::GetFlag(FLAGS_levels), progress);
  const int32_t worker_count = absl::GetFlag(FLAGS_workers);
  std::vector<std::thread> workers;
  workers.reserve(static_cast<size_t>(worker_count));
  for (int32_t i = 0; i < worker_count; ++i) {
    workers.emplace_back([&levels] { levels.Search(absl::GetFlag(FLAGS_bursts)); });
  }
  for (std::thread& worker : workers) {
    worker.join();
  }
  progress.Finish(game_mode.Name(), absl::StrCat(levels.SeedsOf(Verdict::kSolved).size(), " of ",
                                                 levels.results().size(), " solved"));
  WriteWays(levels, ways);
  return Summarize(levels, absl::Now() - begin);
}

std::vector<std::string> GuidedGames() {
  std::vector<std::string> names;
  for (const SearchHeuristic& heuristic : SearchHeuristics()) {
    names.emplace_back(heuristic.game);
  }
  return names;
}

// Returns every combination of `games` and the flag's modes, game by game. Errors:
// INVALID_ARGUMENT a game without a heuristic, or a mode that it does not have.
absl::StatusOr<std::vector<GameMode>> MakeGameModes(const std::vector<std::string>& games) {
  std::vector<GameMode> game_modes;
  for (const std::string& name : games) {
    if (FindSearchHeuristic(name) == nullptr) {
      return absl::InvalidArgumentError(
          absl::StrCat("game '", name, "' is not one of ", absl::StrJoin(GuidedGames(), ", ")));
    }
    const GameSpec* game = FindGame(name);
    for (const std::string& mode_name : absl::GetFlag(FLAGS_modes)) {
      const std::optional<DistributionMode> mode = FindDistributionMode(mode_name);
      if (!mode.has_value() || !game->HasMode(*mode)) {
        const auto add_name = [](std::string* out, DistributionMode known) {
          absl::StrAppend(out, DistributionModeName(known));
        };
        return absl::InvalidArgumentError(
            absl::StrCat("mode '", mode_name, "' is not one of ", name,
                         "'s modes: ", absl::StrJoin(game->modes, ", ", add_name)));
      }
      game_modes.push_back({.game = game, .mode = *mode});
    }
  }
  return game_modes;
}

// Returns an error in the flags; empty: none.
std::string FlagError() {
  const int32_t first_level = absl::GetFlag(FLAGS_first_level);
  const int32_t level_count = absl::GetFlag(FLAGS_levels);
  if (first_level < 0 || level_count < 1 || first_level > INT32_MAX - level_count) {
    return absl::StrCat("--first_level ", first_level, " --levels ", level_count,
                        ": must be at least 0 and 1, and all seeds below 2^31 - 1");
  }
  if (absl::GetFlag(FLAGS_workers) < 1) {
    return absl::StrCat("--workers ", absl::GetFlag(FLAGS_workers), ": must be at least 1");
  }
  if (absl::GetFlag(FLAGS_bursts) < 1) {
    return absl::StrCat("--bursts ", absl::GetFlag(FLAGS_bursts), ": must be at least 1");
  }
  return "";
}

// Prints all summaries. Returns whether all are good.
bool Print(const std::vector<Summary>& summaries) {
  std::cout
      << "| game | mode | solved | unsolvable | given up | mean length | bursts | steps | seconds "
         "|\n| --- | --- | --- | --- | --- | --- | --- | --- | --- |\n";
  for (const Summary& summary : summaries) {
    std::cout << summary.row << "\n";
  }
  bool good = true;
  for (const Summary& summary : summaries) {
    for (const std::string& note : summary.notes) {
      std::cout << note << "\n";
    }
    good = good && summary.good;
  }
  return good;
}

int Fail(absl::string_view error) {
  std::cerr << "procgen-solve: " << error << "\n";
  return 2;
}

int Main(const std::vector<char*>& arguments) {
  std::string error = FlagError();
  if (arguments.size() > 1) {
    error = absl::StrCat("unexpected argument '", arguments[1], "': only flags are allowed");
  }
  std::vector<std::string> games = absl::GetFlag(FLAGS_games);
  if (games.empty()) {
    games = GuidedGames();
  }
  const auto game_modes = MakeGameModes(games);
  if (error.empty() && !game_modes.ok()) {
    error = std::string(game_modes.status().message());
  }
  if (!error.empty()) {
    return Fail(error);
  }
  const std::string ways_path = absl::GetFlag(FLAGS_ways);
  std::ofstream ways;
  if (!ways_path.empty()) {
    ways.open(ways_path);
    if (!ways) {
      return Fail(absl::StrCat("cannot write to ", ways_path));
    }
  }
  Progress progress(game_modes->size());
  std::vector<Summary> summaries;
  for (const GameMode& game_mode : *game_modes) {
    summaries.push_back(RunGameMode(game_mode, progress, ways));
  }
  const bool good = Print(summaries);
  ways.flush();
  if (!ways_path.empty() && !ways) {
    return Fail(absl::StrCat("cannot write to ", ways_path));
  }
  return good ? 0 : 1;
}

}  // namespace
}  // namespace procgen

int main(int argc, char** argv) {
  absl::SetProgramUsageMessage(
      "Searches for a solution of each level and verifies it by playing it again.\n"
      "usage: procgen-solve [--games NAME,...] [--modes NAME,...] [--first_level N] [--levels N] "
      "[--workers N] [--bursts N] [--ways FILE]");
  return procgen::Main(absl::ParseCommandLine(argc, argv));
}
