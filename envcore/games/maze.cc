// Maze: a mouse in a maze searches for a piece of cheese (+10, level complete). Levels are perfect
// mazes of random size in the middle of a field of wall. Everything moves in whole cells.

#include "envcore/level/maze.h"

#include "envcore/games/game.h"
#include "envcore/games/game_spec.h"

namespace procgen {
namespace {

constexpr int kCheeseKind = 2;
constexpr int kDecoyKind = 3;  // of a variant (game_variants.cc)

constexpr KindName kKinds[] = {{kCheeseKind, "cheese", true}, {kDecoyKind, "decoy"}};

constexpr int kWorldSideEasy = 15;  // cells
constexpr int kWorldSideHard = 25;
constexpr int kWorldSideMemory = 31;
constexpr float kCellsInViewMemory = 8;
constexpr int kMazeSizeMin = 3;       // cells; sizes are odd
constexpr float kAgentRadius = 0.5F;  // cells
constexpr float kCheeseReward = 10;

constexpr ArtSlot kArtSlots[] = {
    {0, 0, "mouse", "kenney/Enemies/mouse_move.png", 128, 128},
    {2, 0, "cheese", "misc_assets/cheese.png", 27, 27},
    {51, 0, "wall", "kenney/Ground/Sand/sandCenter.png", 128, 128},
};

constexpr GameArtSpec kArt = {.slots = kArtSlots, .background_group = BackgroundGroup::kTopdown};

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

class MazeGame final : public Game {
 public:
  explicit MazeGame(const GameOptions& options) : Game(kArt, options) {
    shows_velocity_ = false;
    cells_in_view_ = kCellsInViewMemory;
    world_.out_of_bounds_kind = kWallKind;
    world_.whole_cell_motion = true;
  }

 private:
  void MakeLevel() override {
    const DistributionMode mode = options().distribution_mode;
    const int side = WorldSide(mode);
    StandardReset(side, side, AgentStart::kFixed);
    const int maze_size = random_.Int((side - 1) / 2) * 2 + kMazeSizeMin;
    const int margin = (side - maze_size) / 2;
    center_agent_ = mode == DistributionMode::kMemory;
    Entity& agent = world_.agent();
    agent.rx = kAgentRadius;
    agent.ry = kAgentRadius;
    agent.x = static_cast<float>(margin) + kAgentRadius;
    agent.y = static_cast<float>(margin) + kAgentRadius;

    Maze maze(maze_size);
    maze.MakePlain(random_);
    maze.PlaceObjects(random_, 1, kCheeseKind);
    world_.grid.Fill(0, 0, side, side, kWallKind);
    for (int y = 0; y < maze_size; ++y) {
      for (int x = 0; x < maze_size; ++x) {
        world_.grid.Set(margin + x, margin + y, maze.At(x, y));
      }
    }
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
      agent.mirrored = world_.controls.horizontal > 0;
    }
    const auto x = static_cast<int>(agent.x);
    const auto y = static_cast<int>(agent.y);
    if (world_.CellAt(x, y) == kCheeseKind) {
      world_.grid.Set(x, y, kEmptyKind);
      outcome_.reward += kCheeseReward;
      outcome_.level_complete = true;
    }
    outcome_.done = outcome_.reward > 0;
  }
};

}  // namespace

extern constexpr GameSpec kMaze = {
    .name = "maze",
    .description = "A mouse looks for the cheese in a maze.",
    .modes = kWithMemory,
    .step_limit = 500,
    .step_limit_memory = 500,
    .easy_returns = {5, 10},
    .hard_returns = {4, 10},
    .exploration_level = 158988835,
    .kinds = kKinds,
    .make = MakeGame<MazeGame>,
};

}  // namespace procgen
