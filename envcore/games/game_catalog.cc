#include "envcore/games/game_catalog.h"

#include <algorithm>
#include <array>

namespace procgen {

// The games, sorted by name. Each is defined in its file.
#define PROCGEN_GAMES(GAME) \
  GAME(kBigFish)            \
  GAME(kBossFight)          \
  GAME(kCaveFlyer)          \
  GAME(kChaser)             \
  GAME(kClimber)            \
  GAME(kCoinRun)            \
  GAME(kDodgeball)          \
  GAME(kFruitBot)           \
  GAME(kHeist)              \
  GAME(kJumper)             \
  GAME(kLeaper)             \
  GAME(kMaze)               \
  GAME(kMiner)              \
  GAME(kNinja)              \
  GAME(kPlunder)            \
  GAME(kStarPilot)

#define PROCGEN_DECLARED(game) extern const GameSpec game;
PROCGEN_GAMES(PROCGEN_DECLARED)

namespace {

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

absl::Span<const GameSpec> GameCatalog() {
#define PROCGEN_LISTED(game) game,
  // Copies, made at the first call, from constants that no initialisation has to precede.
  static const GameSpec games[] = {PROCGEN_GAMES(PROCGEN_LISTED)};
  return games;
}

const GameSpec* FindGame(absl::string_view name) {
  const absl::Span<const GameSpec> games = GameCatalog();
  const auto* found = std::find_if(games.begin(), games.end(),
                                   [name](const GameSpec& game) { return game.name == name; });
  return found == games.end() ? nullptr : found;
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
