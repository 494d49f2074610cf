#include "envcore/games/game_variants.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "envcore/games/game_kind_names.h"
#include "envcore/random/random_stream.h"
#include "envcore/world/placing.h"
#include "envcore/world/world.h"

namespace procgen {
namespace {

constexpr VariantSpec kVariants[] = {
    {Variant::kCoinRandom, "coin_random", "coinrun",
     "The coin is at a random place on the ground instead of at the end of the level."},
    {Variant::kCheeseCorner, "cheese_corner", "maze",
     "The cheese is in the upper right corner of the maze, opposite to the start."},
    {Variant::kTwoObjects, "two_objects", "maze",
     "A second object, the decoy, is in another cell; it does nothing."},
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
  const int ground_top = *FindKind("coinrun", "ground_top");
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
  const std::optional<int> coin = FindCell(world->grid, *FindKind("coinrun", "coin"));
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
  const std::optional<int> cheese = FindCell(grid, *FindKind("maze", "cheese"));
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
    SpawnAtCell(*world, *FindKind("maze", "decoy"), kDecoyRadius,
                StreamOf(level_seed).OneOf(cells));
  }
}

}  // namespace

absl::Span<const VariantSpec> VariantCatalog() { return kVariants; }

std::optional<Variant> FindVariant(absl::string_view name) {
  if (name.empty()) {
    return Variant::kNone;
  }
  for (const VariantSpec& spec : kVariants) {
    if (spec.name == name) {
      return spec.variant;
    }
  }
  return std::nullopt;
}

absl::string_view VariantName(Variant variant) {
  for (const VariantSpec& spec : kVariants) {
    if (spec.variant == variant) {
      return spec.name;
    }
  }
  return "";
}

void ApplyVariant(Variant variant, int32_t level_seed, World* world) {
  switch (variant) {
    case Variant::kNone:
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
