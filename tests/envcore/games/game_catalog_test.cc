#include "envcore/games/game_catalog.h"

#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

using ::testing::ElementsAre;
using ::testing::ElementsAreArray;
using ::testing::SizeIs;

std::vector<std::string> GamesWith(DistributionMode mode) {
  std::vector<std::string> names;
  for (const GameSpec& game : GameCatalog()) {
    if (game.HasMode(mode)) {
      names.emplace_back(game.name);
    }
  }
  return names;
}

TEST(GameCatalogTest, HasTheSixteenGamesSortedByName) {
  std::vector<std::string> names;
  for (const GameSpec& game : GameCatalog()) {
    names.emplace_back(game.name);
  }
  EXPECT_THAT(names, ElementsAre("bigfish", "bossfight", "caveflyer", "chaser", "climber",
                                 "coinrun", "dodgeball", "fruitbot", "heist", "jumper", "leaper",
                                 "maze", "miner", "ninja", "plunder", "starpilot"));
}

TEST(GameCatalogTest, SpecialActionsAreInOrderAndDescribed) {
  for (const GameSpec& game : GameCatalog()) {
    int32_t last = 8;
    for (const SpecialAction& special : game.special_actions) {
      EXPECT_GT(special.action, last) << game.name;
      EXPECT_LT(special.action, kActionCount) << game.name;
      EXPECT_TRUE(absl::EndsWith(special.description, ".")) << game.name;
      last = special.action;
    }
  }
}

TEST(GameCatalogTest, FindsGamesByTheirFullName) {
  EXPECT_EQ(FindGame("miner")->name, "miner");
  EXPECT_EQ(FindGame("mine"), nullptr);
  EXPECT_EQ(FindGame("Miner"), nullptr);
  EXPECT_EQ(FindGame(""), nullptr);
}

TEST(GameCatalogTest, ModesAreThoseOfTheSpecification) {
  EXPECT_THAT(GamesWith(DistributionMode::kEasy), SizeIs(16));
  EXPECT_THAT(GamesWith(DistributionMode::kHard), SizeIs(16));
  EXPECT_THAT(GamesWith(DistributionMode::kExtreme),
              ElementsAre("chaser", "dodgeball", "leaper", "starpilot"));
  EXPECT_THAT(GamesWith(DistributionMode::kMemory),
              ElementsAre("caveflyer", "dodgeball", "heist", "jumper", "maze", "miner"));
}

TEST(GameCatalogTest, ExplorationLevelsAreThoseOfTheSpecification) {
  std::map<std::string, int32_t> levels;
  for (const GameSpec& game : GameCatalog()) {
    if (game.exploration_level.has_value()) {
      levels[std::string(game.name)] = *game.exploration_level;
    }
  }
  EXPECT_EQ(levels, (std::map<std::string, int32_t>{{"coinrun", 1949448038},
                                                    {"caveflyer", 1259048185},
                                                    {"leaper", 1318677581},
                                                    {"jumper", 1434825276},
                                                    {"maze", 158988835},
                                                    {"heist", 876640971},
                                                    {"climber", 1561126160},
                                                    {"ninja", 1123500215}}));
}

TEST(GameCatalogTest, StepLimitsAreThoseOfTheSpecification) {
  const std::map<std::string, int32_t> other = {
      {"bigfish", 6000}, {"bossfight", 4000}, {"plunder", 4000}, {"leaper", 500}, {"maze", 500}};
  for (const GameSpec& game : GameCatalog()) {
    const auto found = other.find(std::string(game.name));
    const int32_t limit = found == other.end() ? 1000 : found->second;
    for (const DistributionMode mode : game.modes) {
      const bool is_jumper_memory = game.name == "jumper" && mode == DistributionMode::kMemory;
      EXPECT_EQ(game.StepLimit(mode), is_jumper_memory ? 2000 : limit)
          << game.name << " " << DistributionModeName(mode);
    }
  }
}

TEST(GameCatalogTest, ArtSeedsAreThoseOfTheSpecification) {
  const std::map<std::string, uint32_t> seeds = {
      {"bigfish", 1427991231U},   {"climber", 1094961757U},  {"heist", 2315743850U},
      {"miner", 4146154380U},     {"bossfight", 700713674U}, {"coinrun", 82037353U},
      {"jumper", 97948414U},      {"ninja", 4202899371U},    {"caveflyer", 297472026U},
      {"dodgeball", 2415608597U}, {"leaper", 384011440U},    {"plunder", 1048057625U},
      {"chaser", 1727450461U},    {"fruitbot", 3179194258U}, {"maze", 3848665378U},
      {"starpilot", 3304989165U}};
  for (const GameSpec& game : GameCatalog()) {
    EXPECT_EQ(game.ArtSeed(), seeds.at(std::string(game.name))) << game.name;
  }
}

TEST(GameCatalogTest, ReturnRangesAreNotRoundedToFloats) {
  EXPECT_EQ(FindGame("climber")->easy_returns.max, 12.6);
  EXPECT_EQ(FindGame("fruitbot")->hard_returns.max, 27.2);
}

TEST(GameCatalogTest, ModeNamesRoundTrip) {
  for (const char* name : {"easy", "hard", "extreme", "memory", "exploration"}) {
    ASSERT_TRUE(FindDistributionMode(name).has_value()) << name;
    EXPECT_EQ(DistributionModeName(*FindDistributionMode(name)), name);
  }
  EXPECT_FALSE(FindDistributionMode("medium").has_value());
  EXPECT_EQ(DistributionModeName(static_cast<DistributionMode>(3)), "unknown");
}

TEST(GameCatalogTest, ActionsAreNamedByTheirKeys) {
  EXPECT_EQ(ActionName(0), "LEFT+DOWN");
  EXPECT_EQ(ActionName(kNoAction), "NONE");
  EXPECT_EQ(ActionName(8), "RIGHT+UP");
  EXPECT_EQ(ActionName(9), "D");
  EXPECT_EQ(ActionName(kActionCount - 1), "E");
}

// The rows of the specification's table of art slots: "kind,theme,file,width,height" by game.
std::map<std::string, std::set<std::string>> SpecifiedSlots() {
  std::map<std::string, std::set<std::string>> slots;
  std::ifstream file(PROCGEN_SOURCE_DIR "/../shared/spec/art_slots.csv");
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    const std::vector<std::string> fields = absl::StrSplit(line, ',');
    slots[fields[0]].insert(
        absl::StrCat(fields[1], ",", fields[2], ",", fields[3], ",", fields[4], ",", fields[5]));
  }
  return slots;
}

std::set<std::string> SlotsOf(absl::Span<const ArtSlot> slots) {
  std::set<std::string> rows;
  for (const ArtSlot& slot : slots) {
    rows.insert(absl::StrCat(slot.kind, ",", slot.theme, ",", slot.upstream_path, ",",
                             slot.width_px, ",", slot.height_px));
  }
  return rows;
}

// Image sizes are rules. Skipped if the specification is not next to the checkout.
TEST(GameCatalogTest, ArtSlotsAreThoseOfTheSpecification) {
  const auto specified = SpecifiedSlots();
  if (specified.empty()) {
    GTEST_SKIP() << "no specification next to the checkout";
  }
  const std::set<std::string> shared = SlotsOf(SharedArtSlots());
  EXPECT_THAT(shared, ElementsAreArray(specified.at("*")));
  for (const GameSpec& game : GameCatalog()) {
    // The table may list a shared slot again for a game that shows it.
    std::set<std::string> expected = specified.at(std::string(game.name));
    expected.insert(shared.begin(), shared.end());
    std::set<std::string> got =
        SlotsOf(game.make({.distribution_mode = game.modes[0]})->art().slots);
    got.insert(shared.begin(), shared.end());
    EXPECT_EQ(got, expected) << game.name;
  }
}

TEST(GameCatalogTest, EverySlotIsListedOnceAndCanBeDrawn) {
  for (const GameSpec& game : GameCatalog()) {
    std::set<std::pair<int, int>> seen;
    const auto made = game.make({.distribution_mode = game.modes[0]});
    for (const ArtSlot& slot : made->art().slots) {
      EXPECT_TRUE(seen.insert({slot.kind, slot.theme}).second)
          << game.name << " " << slot.kind << "," << slot.theme;
      EXPECT_GE(slot.kind, 0);
      EXPECT_LT(slot.kind, kKindCount);
      EXPECT_GE(slot.theme, 0);
      EXPECT_LT(slot.theme, 11);  // dodgeball lists eleven enemies and shows seven
      EXPECT_GT(slot.width_px, 0);
      EXPECT_GT(slot.height_px, 0);
    }
  }
}

}  // namespace
}  // namespace procgen
