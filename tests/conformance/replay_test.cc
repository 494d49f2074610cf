// Recordings of the released benchmark, replayed by one worker and by two. Those of golden/ always;
// those beside the checkout where there are any.

#include "tests/conformance/replay.h"

#include <algorithm>
#include <filesystem>
#include <string>
#include <tuple>
#include <vector>

#include "absl/strings/str_replace.h"
#include "envcore/games/game_catalog.h"
#include "gtest/gtest.h"
#include "tests/conformance/player.h"
#include "tests/conformance/recorded_states.h"
#include "tests/conformance/trace.h"

namespace procgen {
namespace {

std::vector<std::string> TracesIn(const std::string& folder) {
  std::vector<std::string> paths;
  if (std::filesystem::is_directory(folder)) {
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      if (entry.path().extension() == ".trace") {
        paths.push_back(entry.path().string());
      }
    }
  }
  std::sort(paths.begin(), paths.end());
  return paths;
}

std::string NameOf(const std::string& path) {
  return absl::StrReplaceAll(std::filesystem::path(path).stem().string(), {{".", "_"}, {"-", "_"}});
}

// Replays the file and returns the first difference, or what else is wrong; empty: none.
std::string Replayed(const std::string& path, int32_t worker_count) {
  const absl::StatusOr<Trace> trace = ReadTrace(path);
  if (!trace.ok()) {
    return trace.status().ToString();
  }
  auto player = MakeLocalPlayer(*trace, worker_count, trace->HasComparablePictures());
  return player.ok() ? FirstDifference(*trace, **player) : player.status().ToString();
}

class GoldenReplayTest : public testing::TestWithParam<std::tuple<std::string, int32_t>> {};

TEST_P(GoldenReplayTest, IsAsRecorded) {
  EXPECT_EQ(Replayed(std::get<0>(GetParam()), std::get<1>(GetParam())), "");
}

INSTANTIATE_TEST_SUITE_P(
    Files, GoldenReplayTest,
    testing::Combine(testing::ValuesIn(TracesIn(PROCGEN_SOURCE_DIR "/tests/conformance/golden")),
                     testing::Values(1, 2)),
    [](const auto& info) {
      return NameOf(std::get<0>(info.param)) + "_by_" + std::to_string(std::get<1>(info.param));
    });

std::vector<std::string> GamesThatAreThere() {
  std::vector<std::string> names;
  for (const GameFacts& game : GameCatalog()) {
    if (game.make != nullptr) {
      names.emplace_back(game.name);
    }
  }
  return names;
}

class ReferenceReplayTest : public testing::TestWithParam<std::string> {};

TEST_P(ReferenceReplayTest, AllRecordingsAreAsRecorded) {
  int count = 0;
  for (const char* folder : {"/rollouts", "/solved"}) {
    for (const std::string& path : TracesIn(ReferenceFolder() + folder)) {
      const std::string file = std::filesystem::path(path).filename().string();
      if (file.substr(0, file.find('.')) == GetParam()) {
        ++count;
        EXPECT_EQ(Replayed(path, 1), "") << file;
      }
    }
  }
  if (count == 0) {
    GTEST_SKIP() << "no recordings of " << GetParam() << " beside the checkout";
  }
}

INSTANTIATE_TEST_SUITE_P(Catalog, ReferenceReplayTest, testing::ValuesIn(GamesThatAreThere()),
                         [](const auto& info) { return info.param; });

}  // namespace
}  // namespace procgen
