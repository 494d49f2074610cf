#include "tools/solver/search.h"

#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tools/solver/search_heuristic.h"

namespace procgen {
namespace {

constexpr int64_t kBurstCountMax = 20000;
constexpr int32_t kMazeLevel = 3;
// A spike man stands where the agent starts.
constexpr int32_t kJumperLostLevel = 5;
// The exit of the first room is closed by bricks.
constexpr int32_t kNinjaClosedLevel = 59;

SearchResult SearchEasy(const std::string& game, int32_t level_seed,
                        int64_t burst_count_max = kBurstCountMax) {
  return SearchLevel(*FindGame(game), *FindSearchHeuristic(game), DistributionMode::kEasy,
                     level_seed, burst_count_max);
}

bool CompletesEasyMaze(const std::vector<int32_t>& actions) {
  return CompletesLevel(*FindGame("maze"), DistributionMode::kEasy, kMazeLevel, actions);
}

class EveryHeuristic : public testing::TestWithParam<SearchHeuristic> {};

TEST_P(EveryHeuristic, SolvesTheFirstLevels) {
  const GameSpec& game = *FindGame(GetParam().game);
  for (int32_t level_seed = 0; level_seed < 5; ++level_seed) {
    const SearchResult result =
        SearchLevel(game, GetParam(), DistributionMode::kEasy, level_seed, kBurstCountMax);
    EXPECT_EQ(result.verdict, Verdict::kSolved) << level_seed;
    EXPECT_TRUE(CompletesLevel(game, DistributionMode::kEasy, level_seed, result.actions))
        << level_seed;
  }
}

INSTANTIATE_TEST_SUITE_P(SearchTest, EveryHeuristic, testing::ValuesIn(SearchHeuristics()),
                         [](const auto& test) { return std::string(test.param.game); });

TEST(SearchTest, EqualSearchesFindEqualSolutions) {
  const SearchResult result = SearchEasy("ninja", 1);
  const SearchResult again = SearchEasy("ninja", 1);
  EXPECT_EQ(result.actions, again.actions);
  EXPECT_EQ(result.step_count, again.step_count);
}

TEST(SearchTest, GivesUpAfterItsBursts) {
  const SearchResult result = SearchEasy("climber", 0, /*burst_count_max=*/3);
  EXPECT_EQ(result.verdict, Verdict::kGivenUp);
  EXPECT_EQ(result.burst_count, 3);
  EXPECT_THAT(result.actions, testing::IsEmpty());
}

TEST(SearchTest, ALevelLostInItsFirstStepIsReported) {
  EXPECT_EQ(SearchEasy("jumper", kJumperLostLevel).verdict, Verdict::kLostAtOnce);
}

TEST(SearchTest, AClosedOffLevelIsReported) {
  EXPECT_EQ(SearchEasy("ninja", kNinjaClosedLevel).verdict, Verdict::kClosedOff);
}

TEST(CompletesLevelTest, RequiresExactlyTheWholeSolution) {
  const std::vector<int32_t> way = SearchEasy("maze", kMazeLevel).actions;
  EXPECT_TRUE(CompletesEasyMaze(way));
  std::vector<int32_t> shorter = way;
  shorter.pop_back();
  EXPECT_FALSE(CompletesEasyMaze(shorter));
  std::vector<int32_t> longer = way;
  longer.push_back(kNoAction);
  EXPECT_FALSE(CompletesEasyMaze(longer));
}

TEST(CompletesLevelTest, AnEndWithoutCompletionIsNotACompletion) {
  EXPECT_FALSE(CompletesEasyMaze(std::vector<int32_t>(500, kNoAction)));
}

}  // namespace
}  // namespace procgen
