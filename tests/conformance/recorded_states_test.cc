// Levels and steps of every game, compared with recorded states of Procgen 0.10.7: the world, every
// entity field, every cell and the number of draws. Skipped if the recordings are not next to the
// checkout.

#include "tests/conformance/recorded_states.h"

#include <filesystem>

#include "absl/strings/str_cat.h"
#include "envcore/games/game_catalog.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/conformance/recordings.h"

namespace procgen {
namespace {

using Json = nlohmann::json;

// Floats are recorded with nine digits, which identify an f32.
bool SameNumber(const Json& expected, const Json& got) {
  return expected.get<float>() == got.get<float>();
}

// Returns the first difference between `got` and the recording; empty: none. Ignores members that
// only one side has.
// NOLINTNEXTLINE(misc-no-recursion): as deep as the recording
std::string FirstDifference(const std::string& place, const Json& expected, const Json& got) {
  if (expected.is_object()) {
    for (const auto& [name, value] : expected.items()) {
      if (got.contains(name)) {
        std::string difference = FirstDifference(absl::StrCat(place, ".", name), value, got[name]);
        if (!difference.empty()) {
          return difference;
        }
      }
    }
    return "";
  }
  if (expected.is_array()) {
    for (size_t i = 0; i < std::min(expected.size(), got.size()); ++i) {
      std::string difference =
          FirstDifference(absl::StrCat(place, "[", i, "]"), expected[i], got[i]);
      if (!difference.empty()) {
        return difference;
      }
    }
    return expected.size() == got.size()
               ? ""
               : absl::StrCat(place, " has ", got.size(), " elements, recorded ", expected.size());
  }
  const bool same = expected.is_number() ? SameNumber(expected, got) : expected == got;
  return same ? "" : absl::StrCat(place, " is ", got.dump(), ", recorded ", expected.dump());
}

struct Recording {
  std::string name;  // of the file, for messages
  const GameSpec* game;
  DistributionMode mode;
  std::vector<Json> lines;
};

std::vector<Recording> Recordings(const std::string& kind) {
  std::vector<Recording> recordings;
  for (const GameSpec& game : GameCatalog()) {
    for (const DistributionMode mode : game.modes) {
      const std::string name = absl::StrCat(game.name, ".", DistributionModeName(mode), ".", kind);
      const std::string path = absl::StrCat(ReferenceFolder(), "/", kind, "/", name, ".jsonl.gz");
      recordings.push_back({name, &game, mode, ReadGzippedJsonLines(path)});
    }
  }
  return recordings;
}

std::unique_ptr<Game> MakeGame(const Recording& recording) {
  GameOptions options;
  options.distribution_mode = recording.mode;
  return recording.game->make(options);
}

class RecordedStatesTest : public testing::Test {
 protected:
  void SetUp() override {
    if (ReferenceFolder().empty()) {
      GTEST_SKIP() << "no recordings next to the checkout";
    }
  }
};

TEST_F(RecordedStatesTest, NewLevelsMatchTheRecordings) {
  for (const Recording& recording : Recordings("levels")) {
    for (const Json& line : recording.lines) {
      const std::unique_ptr<Game> game = MakeGame(recording);
      game->StartLevel(line["level_seed"]);
      const std::string where = absl::StrCat(recording.name, " level ", line["level_seed"].dump());
      EXPECT_EQ(game->random().draws(), line["draws"].get<uint64_t>()) << where;
      EXPECT_EQ(FirstDifference(where, line["state"], StateOf(*game, true)), "");
    }
  }
}

// Replays the episodes of a recording, each up to the step in which it ends.
void ExpectStepsAsRecorded(const Recording& recording) {
  std::unique_ptr<Game> game;
  bool ended = false;
  for (size_t i = 0; i < recording.lines.size(); ++i) {
    const Json& line = recording.lines[i];
    const std::string where = absl::StrCat(recording.name, " line ", i + 1);
    if (line["step"] == 0) {
      game = MakeGame(recording);
      game->StartLevel(line["level_seed"]);
      ended = false;
    } else if (!ended) {
      game->Play(recording.lines[i - 1]["next_action"]);
      ended = line["first"] == 1;
      ASSERT_EQ(game->outcome().reward, line["reward"].get<float>()) << where;
      ASSERT_EQ(game->outcome().level_complete, line["complete"] == 1) << where;
    }
    if (!ended) {
      ASSERT_EQ(game->random().draws(), line["draws"].get<uint64_t>()) << where;
      ASSERT_EQ(FirstDifference(where, line["state"], StateOf(*game, false)), "");
    }
  }
}

TEST_F(RecordedStatesTest, StepsMatchTheRecordings) {
  for (const Recording& recording : Recordings("steps")) {
    ExpectStepsAsRecorded(recording);
  }
}

}  // namespace
}  // namespace procgen
