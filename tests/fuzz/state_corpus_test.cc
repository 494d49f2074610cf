// The seed inputs of state_fuzz are valid snapshots of the current version. Otherwise the fuzz
// target would start with rejected inputs only.

#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>

#include "envcore/environment/environment.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

TEST(StateCorpusTest, EveryGameHasSnapshotsThatCanBeRestored) {
  std::multiset<std::string> games;
  const std::string folder = PROCGEN_SOURCE_DIR "/tests/fuzz/corpus/state";
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    SCOPED_TRACE(entry.path().string());
    if (entry.path().extension() != ".pgst") {
      continue;  // an input that once failed
    }
    const std::string stem = entry.path().stem().string();
    const std::string game = stem.substr(0, stem.find('_'));
    std::ifstream file(entry.path(), std::ios::binary);
    const std::string snapshot(std::istreambuf_iterator<char>(file), {});
    ASSERT_NE(FindGame(game), nullptr);
    EXPECT_THAT(Environment::Restore(*FindGame(game), snapshot, AutoresetMode::kSameStep), IsOk());
    games.insert(game);
  }
  for (const GameSpec& spec : GameCatalog()) {
    EXPECT_EQ(games.count(std::string(spec.name)), 2) << spec.name;
  }
}

}  // namespace
}  // namespace procgen
