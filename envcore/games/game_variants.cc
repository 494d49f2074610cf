#include "envcore/games/game_variants.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "envcore/games/game_catalog.h"
#include "envcore/random/random_stream.h"
#include "envcore/world/placing.h"
#include "envcore/world/world.h"

namespace procgen {
namespace {

constexpr absl::string_view kGravityDescription =
    "Speed that the agent gains downwards, in cells per step, in each step.";
constexpr absl::string_view kJumpSpeedDescription =
    "Speed of the agent at the beginning of a jump, in cells per step.";
constexpr VariantSpec kVariants[] = {
    {Variant::kCoinRandom, "coin_random", "coinrun",
     "The coin is at a random place on the ground instead of at the end of the level."},
    {Variant::kCheeseCorner, "cheese_corner", "maze",
     "The cheese is in the upper right corner of the maze, opposite to the start."},
    {Variant::kTwoObjects, "two_objects", "maze",
     "A second object, the decoy, is in another cell; it does nothing."},
    {Variant::kGravity, "gravity", "climber", kGravityDescription, 0.2F},
    {Variant::kGravity, "gravity", "coinrun", kGravityDescription, 0.2F},
    {Variant::kGravity, "gravity", "jumper", kGravityDescription, 0.15F},
    {Variant::kGravity, "gravity", "ninja", kGravityDescription, 0.2F},
    {Variant::kJumpSpeed, "jump_speed", "climber", kJumpSpeedDescription, 1.5F},
    {Variant::kJumpSpeed, "jump_speed", "coinrun", kJumpSpeedDescription, 1.5F},
    {Variant::kJumpSpeed, "jump_speed", "jumper", kJumpSpeedDescription, 1},
    {Variant::kEnemySpeed, "enemy_speed", "dodgeball", "Speed of the enemies, in cells per step.",
     0.05F},
    {Variant::kThrustSpeed, "thrust_speed", "caveflyer",
     "Speed to which the thrust of a step is a fifth, in cells per step.", 0.45F},
};

// Distinguishes the stream of a variant from that of the level with the same seed.
constexpr uint32_t kStreamSalt = 0x76617269;

constexpr int kCoinFirstColumn = 3;   // the agent starts in column 1
constexpr float kDecoyRadius = 0.5F;  // cells

void Move(int from, int to, Grid* grid) {
  grid->Set(to, grid->At(from));
  if (from != to) {
    grid->Set(from, kEmptyKind);
  }
}

// Returns the first cell of a kind; absent if there is none.
std::optional<int> FindCell(const Grid& grid, int kind) {
  for (int cell = 0; cell < grid.size(); ++cell) {
    if (grid.At(cell) == kind) {
      return cell;
    }
  }
  return std::nullopt;
}

RandomStream StreamOf(int32_t level_seed) {
  return RandomStream(static_cast<int32_t>(static_cast<uint32_t>(level_seed) ^ kStreamSalt));
}

bool HasEntity(const World& world, int x, int y) {
  return std::any_of(world.entities.begin(), world.entities.end(), [x, y](const Entity& entity) {
    return std::floor(entity.x) == static_cast<float>(x) &&
           std::floor(entity.y) == static_cast<float>(y);
  });
}

// Empty cells on the ground, in which nothing stands. In a new level every cell at the bottom of a
// pit has lava, a saw or a walker, so these are the cells that the agent walks through.
std::vector<int> CellsOnGround(const World& world) {
  const int ground_top = *FindGame("coinrun")->FindKind("ground_top");
  std::vector<int> cells;
  for (int y = 1; y < world.grid.height(); ++y) {
    for (int x = kCoinFirstColumn; x < world.grid.width(); ++x) {
      if (world.grid.At(x, y) == kEmptyKind && world.grid.At(x, y - 1) == ground_top &&
          !HasEntity(world, x, y)) {
        cells.push_back(world.grid.IndexOf(x, y));
      }
    }
  }
  return cells;
}

void PlaceCoinAtRandom(int32_t level_seed, World* world) {
  const std::optional<int> coin = FindCell(world->grid, *FindGame("coinrun")->FindKind("coin"));
  std::vector<int> cells = CellsOnGround(*world);
  if (!coin.has_value()) {
    return;
  }
  cells.push_back(*coin);
  Move(*coin, StreamOf(level_seed).OneOf(cells), &world->grid);
}

// The corner cell of a maze is never wall: mazes have odd sizes, and rooms in even places.
void PlaceCheeseInCorner(World* world) {
  Grid& grid = world->grid;
  const std::optional<int> cheese = FindCell(grid, *FindGame("maze")->FindKind("cheese"));
  int corner = 0;
  for (int cell = 0; cell < grid.size(); ++cell) {
    if (grid.At(cell) != kWallKind) {
      corner = cell;  // rows from below, each from the left: the last is in the upper right corner
    }
  }
  if (cheese.has_value()) {
    Move(*cheese, corner, &grid);
  }
}

// The art of the game has no image for the decoy, so it is drawn as a generated figure, the same in
// all levels. Rules of the game do not know its kind.
void AddDecoy(int32_t level_seed, World* world) {
  const Grid& grid = world->grid;
  std::vector<int> cells;
  for (int cell = 0; cell < grid.size(); ++cell) {
    if (grid.At(cell) == kEmptyKind &&
        !HasEntity(*world, cell % grid.width(), cell / grid.width())) {
      cells.push_back(cell);
    }
  }
  if (!cells.empty()) {
    SpawnAtCell(*world, *FindGame("maze")->FindKind("decoy"), kDecoyRadius,
                StreamOf(level_seed).OneOf(cells));
  }
}

// The shortest text that is read as this value.
std::string Text(absl::string_view name, float value) {
  if (value == 0) {
    return std::string(name);
  }
  std::array<char, 32> digits;
  const char* const end = std::to_chars(digits.begin(), digits.end(), value).ptr;
  return absl::StrCat(name, "=", absl::string_view(digits.data(), end - digits.data()));
}

}  // namespace

absl::Span<const VariantSpec> VariantCatalog() { return kVariants; }

const VariantSpec* FindVariant(absl::string_view game, Variant variant) {
  for (const VariantSpec& spec : kVariants) {
    if (spec.game == game && spec.variant == variant) {
      return &spec;
    }
  }
  return nullptr;
}

bool SetVariant(absl::string_view text, GameOptions* options) {
  options->variant = Variant::kNone;
  options->variant_value = 0;
  if (text.empty()) {
    return true;
  }
  const std::pair<absl::string_view, absl::string_view> parts =
      absl::StrSplit(text, absl::MaxSplits('=', 1));
  for (const VariantSpec& spec : kVariants) {
    if (spec.name == parts.first) {
      options->variant = spec.variant;
      return spec.value == 0 ? spec.name == text
                             : absl::SimpleAtof(parts.second, &options->variant_value);
    }
  }
  return false;
}

std::string VariantText(Variant variant, float value) {
  for (const VariantSpec& spec : kVariants) {
    if (spec.variant == variant) {
      return Text(spec.name, value);
    }
  }
  return "";
}

std::string VariantText(const VariantSpec& spec) { return Text(spec.name, spec.value); }

void ApplyVariant(Variant variant, int32_t level_seed, World* world) {
  switch (variant) {
    case Variant::kNone:
    case Variant::kGravity:
    case Variant::kJumpSpeed:
    case Variant::kEnemySpeed:
    case Variant::kThrustSpeed:
      break;
    case Variant::kCoinRandom:
      PlaceCoinAtRandom(level_seed, world);
      break;
    case Variant::kCheeseCorner:
      PlaceCheeseInCorner(world);
      break;
    case Variant::kTwoObjects:
      AddDecoy(level_seed, world);
      break;
  }
}

}  // namespace procgen
