#include "envcore/games/game_catalog.h"

#include <algorithm>
#include <array>

#include "absl/strings/string_view.h"
#include "envcore/games/game_factories.h"

namespace procgen {
namespace {

constexpr DistributionMode kEasyHard[] = {DistributionMode::kEasy, DistributionMode::kHard};
constexpr DistributionMode kWithExtreme[] = {DistributionMode::kEasy, DistributionMode::kHard,
                                             DistributionMode::kExtreme};
constexpr DistributionMode kWithMemory[] = {DistributionMode::kEasy, DistributionMode::kHard,
                                            DistributionMode::kMemory};
constexpr DistributionMode kAllModes[] = {DistributionMode::kEasy, DistributionMode::kHard,
                                          DistributionMode::kExtreme, DistributionMode::kMemory};

constexpr SpecialAction kBossFightActions[] = {
    {9, "Fires a bullet upwards, at most once in 3 steps."}};
constexpr SpecialAction kCaveFlyerActions[] = {{9, "Fires a shot where the ship points."}};
constexpr SpecialAction kDodgeballActions[] = {
    {9, "Throws a ball in the direction of the last move, at most once in 7 steps."}};
constexpr SpecialAction kFruitBotActions[] = {
    {9, "Throws a key upwards that opens doors, at most once in 8 steps."}};
constexpr SpecialAction kNinjaActions[] = {{9, "Throws a star ahead, at most one star in 3 steps."},
                                           {10, "Throws a star ahead and up."},
                                           {11, "Throws a star up."},
                                           {12, "Throws a star ahead and down."},
                                           {13, "Throws a star ahead."},
                                           {14, "Throws a star ahead."}};
constexpr SpecialAction kPlunderActions[] = {
    {9, "Fires a cannon ball upwards, at most once in 3 steps."}};
constexpr SpecialAction kStarPilotActions[] = {
    {9, "Fires a bullet forwards."},  {10, "Fires a bullet backwards."},
    {11, "Fires a bullet forwards."}, {12, "Fires a bullet forwards."},
    {13, "Fires a bullet forwards."}, {14, "Fires a bullet forwards."}};

constexpr GameSpec kGames[] = {
    {.name = "bigfish",
     .description = "A fish eats smaller fish to grow and avoids larger ones.",
     .modes = kEasyHard,
     .step_limit = 6000,
     .easy_returns = {1, 40},
     .hard_returns = {0, 40},
     .exploration_level = std::nullopt,
     .special_actions = {},
     .make = MakeBigFish},
    {.name = "bossfight",
     .description = "A ship dodges a boss's bullets and fires back when its shield is down.",
     .modes = kEasyHard,
     .step_limit = 4000,
     .easy_returns = {0.5, 13},
     .hard_returns = {0.5, 13},
     .exploration_level = std::nullopt,
     .special_actions = kBossFightActions,
     .make = MakeBossFight},
    {.name = "caveflyer",
     .description = "A ship flies through caves to its friend and shoots what is in the way.",
     .modes = kWithMemory,
     .easy_returns = {3.5, 12},
     .hard_returns = {2, 13.4},
     .exploration_level = 1259048185,
     .special_actions = kCaveFlyerActions,
     .make = MakeCaveFlyer},
    {.name = "chaser",
     .description = "The agent collects all orbs of a maze while enemies chase it.",
     .modes = kWithExtreme,
     .easy_returns = {0.5, 13},
     .hard_returns = {0.5, 14.2},
     .exploration_level = std::nullopt,
     .special_actions = {},
     .make = MakeChaser},
    {.name = "climber",
     .description = "A climber jumps from platform to platform and collects crystals.",
     .modes = kEasyHard,
     .easy_returns = {2, 12.6},
     .hard_returns = {1, 12.6},
     .exploration_level = 1561126160,
     .special_actions = {},
     .make = MakeClimber},
    {.name = "coinrun",
     .description = "A runner jumps over pits, saws and walkers to the coin at the far right.",
     .modes = kEasyHard,
     .easy_returns = {5, 10},
     .hard_returns = {5, 10},
     .exploration_level = 1949448038,
     .special_actions = {},
     .make = MakeCoinRun},
    {.name = "dodgeball",
     .description = "The agent throws balls at enemies, dodges theirs and leaves by the door.",
     .modes = kAllModes,
     .easy_returns = {1.5, 19},
     .hard_returns = {1.5, 19},
     .exploration_level = std::nullopt,
     .special_actions = kDodgeballActions,
     .make = MakeDodgeball},
    {.name = "fruitbot",
     .description = "A robot collects fruit, avoids other food and passes gates and doors.",
     .modes = kEasyHard,
     .easy_returns = {-1.5, 32.4},
     .hard_returns = {-0.5, 27.2},
     .exploration_level = std::nullopt,
     .special_actions = kFruitBotActions,
     .make = MakeFruitBot},
    {.name = "heist",
     .description = "A thief opens coloured locks with their keys to reach the gem.",
     .modes = kWithMemory,
     .easy_returns = {3.5, 10},
     .hard_returns = {2, 10},
     .exploration_level = 876640971,
     .special_actions = {},
     .make = MakeHeist},
    {.name = "jumper",
     .description = "A bunny double-jumps through caves to the carrot that a compass points to.",
     .modes = kWithMemory,
     .step_limit_memory = 2000,
     .easy_returns = {3, 10},
     .hard_returns = {1, 10},
     .exploration_level = 1434825276,
     .special_actions = {},
     .make = MakeJumper},
    {.name = "leaper",
     .description = "A frog crosses roads of cars and rivers of logs.",
     .modes = kWithExtreme,
     .step_limit = 500,
     .easy_returns = {3, 10},
     .hard_returns = {1.5, 10},
     .exploration_level = 1318677581,
     .special_actions = {},
     .make = MakeLeaper},
    {.name = "maze",
     .description = "A mouse looks for the cheese in a maze.",
     .modes = kWithMemory,
     .step_limit = 500,
     .step_limit_memory = 500,
     .easy_returns = {5, 10},
     .hard_returns = {4, 10},
     .exploration_level = 158988835,
     .special_actions = {},
     .make = MakeMaze},
    {.name = "miner",
     .description = "A robot digs for diamonds among falling boulders and leaves by the exit.",
     .modes = kWithMemory,
     .easy_returns = {1.5, 13},
     .hard_returns = {1.5, 20},
     .exploration_level = std::nullopt,
     .special_actions = {},
     .make = MakeMiner},
    {.name = "ninja",
     .description =
         "A ninja jumps over ledges and throws stars at bombs on the way to the mushroom.",
     .modes = kEasyHard,
     .easy_returns = {3.5, 10},
     .hard_returns = {2, 10},
     .exploration_level = 1123500215,
     .special_actions = kNinjaActions,
     .make = MakeNinja},
    {.name = "plunder",
     .description = "A ship fires at enemy ships and spares friendly ones.",
     .modes = kEasyHard,
     .step_limit = 4000,
     .easy_returns = {4.5, 30},
     .hard_returns = {3, 30},
     .exploration_level = std::nullopt,
     .special_actions = kPlunderActions,
     .make = MakePlunder},
    {.name = "starpilot",
     .description = "A ship flies sideways through waves of enemies and shoots them.",
     .modes = kWithExtreme,
     .easy_returns = {2.5, 64},
     .hard_returns = {1.5, 35},
     .exploration_level = std::nullopt,
     .special_actions = kStarPilotActions,
     .make = MakeStarPilot},
};

constexpr std::array<absl::string_view, kActionCount> kActionNames = {
    "LEFT+DOWN", "LEFT", "LEFT+UP", "DOWN", "NONE", "UP", "RIGHT+DOWN", "RIGHT",
    "RIGHT+UP",  "D",    "A",       "W",    "S",    "Q",  "E"};

struct NamedMode {
  DistributionMode mode;
  absl::string_view name;
};

constexpr NamedMode kModes[] = {{DistributionMode::kEasy, "easy"},
                                {DistributionMode::kHard, "hard"},
                                {DistributionMode::kExtreme, "extreme"},
                                {DistributionMode::kMemory, "memory"},
                                {DistributionMode::kExploration, "exploration"}};

}  // namespace

bool GameSpec::HasMode(DistributionMode mode) const {
  if (mode == DistributionMode::kExploration) {
    return exploration_level.has_value();
  }
  return std::find(modes.begin(), modes.end(), mode) != modes.end();
}

// FNV-1a of the name.
uint32_t GameSpec::ArtSeed() const {
  uint32_t hash = 2166136261U;
  for (const char byte : name) {
    hash = (hash ^ static_cast<uint8_t>(byte)) * 16777619U;
  }
  return hash;
}

absl::Span<const GameSpec> GameCatalog() { return kGames; }

const GameSpec* FindGame(absl::string_view name) {
  const auto* found = std::find_if(std::begin(kGames), std::end(kGames),
                                   [name](const GameSpec& game) { return game.name == name; });
  return found == std::end(kGames) ? nullptr : found;
}

absl::string_view DistributionModeName(DistributionMode mode) {
  for (const NamedMode& named : kModes) {
    if (named.mode == mode) {
      return named.name;
    }
  }
  return "unknown";
}

std::optional<DistributionMode> FindDistributionMode(absl::string_view name) {
  for (const NamedMode& named : kModes) {
    if (named.name == name) {
      return named.mode;
    }
  }
  return std::nullopt;
}

absl::string_view ActionName(int32_t action) { return kActionNames[static_cast<size_t>(action)]; }

}  // namespace procgen
