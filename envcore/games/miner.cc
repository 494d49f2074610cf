// Miner: a robot digs through dirt with boulders and diamonds. It collects every diamond (+1) and
// then enters the exit (+10, level complete). Boulders and diamonds fall when their support is dug
// away, and roll off one another. One that is already falling kills the robot when it hits it. Each
// step has one grid move and one pass of gravity.

#include <cmath>

#include "envcore/games/game.h"
#include "envcore/games/game_spec.h"
#include "envcore/world/placing.h"

namespace procgen {
namespace {

constexpr int kBoulderKind = 1;
constexpr int kDiamondKind = 2;
constexpr int kFallingBoulderKind = 3;
constexpr int kFallingDiamondKind = 4;
constexpr int kMinerExitKind = 6;
constexpr int kDirtKind = 9;
constexpr int kBricksKind = 10;  // outside the world

constexpr KindName kKinds[] = {{kBoulderKind, "boulder"},
                               {kDiamondKind, "diamond"},
                               {kFallingBoulderKind, "falling_boulder"},
                               {kFallingDiamondKind, "falling_diamond"},
                               {kMinerExitKind, "exit", true},
                               {kDirtKind, "dirt"},
                               {kBricksKind, "bricks"}};

constexpr int kWorldSideEasy = 10;  // cells
constexpr int kWorldSideHard = 20;
constexpr int kWorldSideMemory = 35;
constexpr float kCellsInViewMemory = 8;
constexpr float kDiamondShare = 12 / 400.0F;  // of the world's cells
constexpr float kBoulderShare = 80 / 400.0F;
constexpr float kRadius = 0.5F;  // of agent and exit, cells
constexpr float kDiamondReward = 1;
constexpr float kExitReward = 10;

constexpr ArtSlot kArtSlots[] = {
    {0, 0, "robot", "misc_assets/robot_greenDrive1.png", 158, 120},
    {1, 0, "boulder", "misc_assets/elementStone007.png", 70, 70},
    {2, 0, "diamond", "misc_assets/gemBlue.png", 72, 51},
    {6, 0, "exit", "misc_assets/window.png", 128, 128},
    {9, 0, "dirt", "misc_assets/dirt.png", 16, 16},
    {10, 0, "bricks", "misc_assets/tile_bricksGrey.png", 64, 64},
};

constexpr GameArtSpec kArt = {.slots = kArtSlots, .background_group = BackgroundGroup::kPlatform};

int WorldSide(DistributionMode mode) {
  switch (mode) {
    case DistributionMode::kEasy:
      return kWorldSideEasy;
    case DistributionMode::kMemory:
      return kWorldSideMemory;
    default:
      return kWorldSideHard;
  }
}

// Boulders and diamonds, which fall and roll off one another.
bool IsRound(int kind) { return kind >= kBoulderKind && kind <= kFallingDiamondKind; }

bool IsFalling(int kind) { return kind == kFallingBoulderKind || kind == kFallingDiamondKind; }

int AtRest(int kind) {
  return IsFalling(kind) ? kind - (kFallingBoulderKind - kBoulderKind) : kind;
}

int Falling(int kind) {
  return kind == kBoulderKind || kind == kDiamondKind ? kind + (kFallingBoulderKind - kBoulderKind)
                                                      : kind;
}

class Miner final : public Game {
 public:
  explicit Miner(const GameOptions& options) : Game(kArt, options) {
    shows_velocity_ = false;
    cells_in_view_ = kCellsInViewMemory;
    world_.out_of_bounds_kind = kBricksKind;
    world_.whole_cell_motion = true;
  }

 private:
  void MakeLevel() override {
    const DistributionMode mode = options().distribution_mode;
    const int side = WorldSide(mode);
    StandardReset(side, side);
    center_agent_ = mode == DistributionMode::kMemory;
    cell_looks_[kFallingBoulderKind].image_kind = kBoulderKind;
    cell_looks_[kFallingDiamondKind].image_kind = kDiamondKind;

    Grid& grid = world_.grid;
    const auto cell_count = static_cast<float>(grid.size());
    const auto diamond_count = static_cast<int32_t>(cell_count * kDiamondShare);
    const auto boulder_count = static_cast<int32_t>(cell_count * kBoulderShare);
    const std::vector<int32_t> places =
        random_.Distinct(grid.size(), diamond_count + boulder_count + 1);
    const int agent_cell = places[0];
    const int agent_column = agent_cell % side;
    const int agent_row = agent_cell / side;
    Entity& agent = world_.agent();
    agent.rx = kRadius;
    agent.ry = kRadius;
    agent.x = static_cast<float>(agent_column) + 0.5F;
    agent.y = static_cast<float>(agent_row) + 0.5F;

    grid.Fill(0, 0, side, side, kDirtKind);
    for (int32_t i = 1; i < static_cast<int32_t>(places.size()); ++i) {
      grid.Set(places[static_cast<size_t>(i)], i <= diamond_count ? kDiamondKind : kBoulderKind);
    }
    std::vector<int32_t> dirt_cells;
    for (int32_t cell = 0; cell < grid.size(); ++cell) {
      if (grid.At(cell) == kDirtKind) {
        dirt_cells.push_back(cell);
      }
    }
    grid.Set(agent_cell, kEmptyKind);
    ClearBouldersAround(agent_column, agent_row);
    PlaceExit(dirt_cells);
  }

  void ClearBouldersAround(int center_x, int center_y) {
    for (int x = center_x - 1; x <= center_x + 1; ++x) {
      for (int y = center_y - 1; y <= center_y + 1; ++y) {
        if (world_.CellAt(x, y) == kBoulderKind) {
          world_.grid.Set(x, y, kDirtKind);
        }
      }
    }
  }

  // Places the exit where dirt, or the top of the world, is above it.
  void PlaceExit(const std::vector<int32_t>& dirt_cells) {
    Grid& grid = world_.grid;
    std::vector<int32_t> candidates;
    for (const int32_t cell : dirt_cells) {
      const int32_t above = cell + grid.width();
      if (above >= grid.size() || grid.At(above) == kDirtKind) {
        candidates.push_back(cell);
      }
    }
    const int32_t exit_cell = random_.OneOf(candidates);
    grid.Set(exit_cell, kEmptyKind);
    Entity& exit = SpawnAtCell(world_, kMinerExitKind, kRadius, exit_cell);
    exit.layer = -1;
  }

  void MapControls() override {
    if (world_.controls.horizontal != 0) {
      world_.controls.vertical = 0;
    }
  }

  void PlayStep() override {
    StandardStep();
    Entity& agent = world_.agent();
    if (world_.controls.horizontal != 0) {
      agent.mirrored = world_.controls.horizontal < 0;
    }
    Push();
    Dig();
    FallAndRoll();
  }

  int AgentCell() const {
    return world_.grid.IndexOf(static_cast<int>(world_.agent().x),
                               static_cast<int>(world_.agent().y));
  }

  // A robot that runs into a boulder at rest pushes it sideways into an empty cell.
  void Push() {
    Entity& agent = world_.agent();
    Grid& grid = world_.grid;
    const int direction = static_cast<int>(world_.controls.horizontal);
    const int cell = AgentCell();
    const int column = cell % grid.width();
    const bool has_room = direction > 0 ? column < grid.width() - 2 : column > 1;
    if (direction == 0 || agent.vx != 0 || !has_room || grid.At(cell + direction) != kBoulderKind ||
        grid.At(cell + 2 * direction) != kEmptyKind) {
      return;
    }
    grid.Set(cell + direction, kEmptyKind);
    grid.Set(cell + 2 * direction, kBoulderKind);
    agent.x += static_cast<float>(direction);
  }

  void Dig() {
    const int cell = AgentCell();
    const int kind = world_.grid.At(cell);
    if (kind == kDiamondKind) {
      outcome_.reward += kDiamondReward;
    }
    if (kind == kDirtKind || kind == kDiamondKind) {
      world_.grid.Set(cell, kEmptyKind);
    }
  }

  // One pass of gravity, from the bottom row up, each cell in its state at the time of the visit.
  // An object that rolls to the right is therefore visited again, and a diamond that does so is
  // counted twice.
  void FallAndRoll() {
    diamonds_left_ = 0;
    for (int cell = 0; cell < world_.grid.size(); ++cell) {
      const int kind = world_.grid.At(cell);
      if (AtRest(kind) == kDiamondKind) {
        ++diamonds_left_;
      }
      if (IsRound(kind)) {
        MoveRound(cell, kind);
      }
    }
  }

  void MoveRound(int cell, int kind) {
    Grid& grid = world_.grid;
    const int width = grid.width();
    const int column = cell % width;
    const int below = cell - width;
    const int below_kind = below < 0 ? kBricksKind : grid.At(below);
    const bool agent_below = AgentCell() == below;
    if (below_kind == kEmptyKind && !agent_below) {
      grid.Set(cell, kEmptyKind);
      grid.Set(below, Falling(kind));
    } else if (agent_below && IsFalling(kind)) {
      outcome_.done = true;
    } else if (IsRound(below_kind) && column > 0 && IsFree(cell - 1) && IsFree(below - 1)) {
      grid.Set(cell, kEmptyKind);
      grid.Set(cell - 1, AtRest(kind));
    } else if (IsRound(below_kind) && column < width - 1 && IsFree(cell + 1) && IsFree(below + 1)) {
      grid.Set(cell, kEmptyKind);
      grid.Set(cell + 1, AtRest(kind));
    } else {
      grid.Set(cell, AtRest(kind));
    }
  }

  bool IsFree(int cell) const { return world_.grid.At(cell) == kEmptyKind && cell != AgentCell(); }

  bool Blocks(const Entity& mover, int kind, Axis axis) override {
    return kind == kBoulderKind || kind == kFallingBoulderKind || Game::Blocks(mover, kind, axis);
  }

  void OnAgentContact(Entity& other) override {
    if (other.kind == kMinerExitKind && diamonds_left_ == 0) {
      outcome_.reward += kExitReward;
      outcome_.level_complete = true;
      outcome_.done = true;
    }
  }

  void VisitOwnState(StateArchive& archive) override {
    // A falling diamond may be counted twice.
    archive.Int("diamonds_left", diamonds_left_, 0, 2 * world_.grid.size());
    const Entity& agent = world_.agent();
    archive.Check(world_.grid.Contains(static_cast<int>(std::floor(agent.x)),
                                       static_cast<int>(std::floor(agent.y))),
                  "has an agent outside of the world");
  }

  // Counted in the last pass of gravity. A new level does not update it, so its first step uses the
  // old number.
  int32_t diamonds_left_ = 0;
};

}  // namespace

extern constexpr GameSpec kMiner = {
    .name = "miner",
    .description = "A robot digs for diamonds among falling boulders and leaves by the exit.",
    .modes = kWithMemory,
    .easy_returns = {1.5, 13},
    .hard_returns = {1.5, 20},
    .kinds = kKinds,
    .make = MakeGame<Miner>,
};

}  // namespace procgen
