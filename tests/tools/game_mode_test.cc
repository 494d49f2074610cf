#include "tools/game_mode.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using ::testing::HasSubstr;

const std::vector<std::string> kKnown = {"heist", "maze"};

TEST(GameModeTest, EachGameIsPlayedInEachMode) {
  const auto game_modes = MakeGameModes({"maze", "heist"}, {"easy", "memory"}, kKnown);
  ASSERT_THAT(game_modes, IsOk());
  std::vector<std::string> names;
  for (const GameMode& game_mode : *game_modes) {
    names.push_back(game_mode.Name());
  }
  EXPECT_THAT(names,
              testing::ElementsAre("maze easy", "maze memory", "heist easy", "heist memory"));
}

TEST(GameModeTest, AnUnknownGameIsRejectedWithTheKnownOnes) {
  EXPECT_THAT(MakeGameModes({"chess"}, {"easy"}, kKnown),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("game 'chess' is not one of heist, maze")));
}

TEST(GameModeTest, AnUnsupportedModeIsRejectedWithTheGamesModes) {
  EXPECT_THAT(
      MakeGameModes({"heist"}, {"extreme"}, kKnown),
      StatusIs(absl::StatusCode::kInvalidArgument,
               HasSubstr("mode 'extreme' is not one of heist's modes: easy, hard, memory")));
}

}  // namespace
}  // namespace procgen
