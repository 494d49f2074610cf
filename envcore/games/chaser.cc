// Chaser: a maze without dead ends, similar to Pac-Man. The agent glides through it and collects
// the small orb of every cell (+0.04 each) while enemies hunt it. A large orb (+0.04) makes the
// enemies slow and edible for a while; an eaten enemy returns as an egg. The level is complete when
// no small orb is left (+10). An enemy that is not edible ends the episode.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "envcore/games/game.h"
#include "envcore/games/game_spec.h"
#include "envcore/level/maze.h"
#include "envcore/world/placing.h"
#include "envcore/world/world_state.h"

namespace procgen {
namespace {

constexpr int kLargeOrbKind = 2;
constexpr int kEdibleEnemyImageKind = 3;
constexpr int kEggKind = 4;
constexpr int kMazeWallKind = 5;
constexpr int kEnemyKind = 6;  // also its image with the wings up
constexpr int kEnemyWingsLevelImageKind = 7;
constexpr int kEnemyWingsDownImageKind = 8;
constexpr int kReservedKind = 1001;  // cell of a large orb, during level generation
constexpr int kSmallOrbKind = 1002;

constexpr KindName kKinds[] = {{kLargeOrbKind, "large_orb"},
                               {kEggKind, "egg"},
                               {kMazeWallKind, "maze_wall"},
                               {kEnemyKind, "enemy"},
                               {kSmallOrbKind, "small_orb"}};

constexpr int kQuadrantCount = 4;
constexpr float kRadius = 0.5F;  // of agent, eggs and enemies, cells
constexpr float kLargeOrbRadius = 0.4F;
constexpr float kAgentSpeed = 0.5F;  // cells per step, on each axis
constexpr float kEnemySpeed = 0.5F;
constexpr float kEdibleEnemySpeed = 0.25F;
constexpr int kEdibleSteps = 75;  // steps after a large orb was taken
constexpr int kEggCountMax = 64;  // limit in a snapshot
constexpr int kHatchSteps = 50;   // steps until an egg hatches, counted down in its health
constexpr float kOrbReward = 0.04F;
constexpr float kCompletionReward = 10;
constexpr double kCellCenterTolerance = 0.01;  // cells; enemies turn at cell centers
constexpr int kFrameSteps = 2;                 // steps per image of the wings
constexpr float kSmallOrbShare = 0.3F;         // side of the drawn square, in cells

// The image sequence of an enemy's wings.
constexpr std::array<int, 4> kWingBeat = {kEnemyKind, kEnemyWingsLevelImageKind,
                                          kEnemyWingsDownImageKind, kEnemyWingsLevelImageKind};

constexpr ArtSlot kArtSlots[] = {
    {0, 0, "agent", "misc_assets/enemyFloating_1b.png", 46, 46},
    {2, 0, "large_orb", "misc_assets/yellowCrystal.png", 36, 34},
    {3, 0, "enemy_edible", "misc_assets/enemyWalking_1b.png", 48, 48},
    {4, 0, "egg", "misc_assets/enemySpikey_1b.png", 44, 44},
    {5, 0, "wall", "misc_assets/tileStone_slope.png", 16, 16},
    {6, 0, "enemy_wings_up", "misc_assets/enemyFlying_1.png", 64, 64},
    {7, 0, "enemy_wings_level", "misc_assets/enemyFlying_2.png", 64, 64},
    {8, 0, "enemy_wings_down", "misc_assets/enemyFlying_3.png", 64, 64},
};

constexpr int kBlockShapedKinds[] = {kMazeWallKind};

constexpr GameArtSpec kArt = {.slots = kArtSlots,
                              .block_shaped_kinds = kBlockShapedKinds,
                              .background_group = BackgroundGroup::kTopdownSimple};

struct ModeFigures {
  int side;                         // of world and maze, cells
  int enemy_count;                  // eggs included
  int large_orbs_special_quadrant;  // the other quadrants have one each
};

ModeFigures FiguresOf(DistributionMode mode) {
  switch (mode) {
    case DistributionMode::kEasy:
      return {.side = 11, .enemy_count = 3, .large_orbs_special_quadrant = 1};
    case DistributionMode::kExtreme:
      return {.side = 19, .enemy_count = 5, .large_orbs_special_quadrant = 2};
    default:
      return {.side = 13, .enemy_count = 3, .large_orbs_special_quadrant = 0};
  }
}

// A step to a neighboring cell.
struct Way {
  int dx = 0;
  int dy = 0;
};

int Sign(float value) { return value > 0 ? 1 : (value < 0 ? -1 : 0); }

class Chaser final : public Game {
 public:
  explicit Chaser(const GameOptions& options)
      : Game(kArt, options), figures_(FiguresOf(options.distribution_mode)) {
    shows_velocity_ = false;
    cell_dots_ = {.kind = kSmallOrbKind, .share = kSmallOrbShare, .color = {0, 255, 0}};
  }

 private:
  // --- Level generation: the maze, large orbs by quadrants, agent and eggs, and small orbs in all
  // other cells.

  void MakeLevel() override {
    const int side = figures_.side;
    StandardReset(side, side);
    center_agent_ = false;
    large_orb_step_ = -kEdibleSteps;

    Maze maze(side);
    maze.MakeWithoutDeadEnds(random_);
    open_cells_.clear();
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x) {
        const bool open = maze.At(x, y) == kEmptyKind;
        world_.grid.Set(x, y, open ? kEmptyKind : kMazeWallKind);
        if (open) {
          open_cells_.push_back(world_.grid.IndexOf(x, y));
        }
      }
    }
    PlaceLargeOrbs();
    PlaceAgentAndEggs();
    for (const int32_t cell : open_cells_) {
      const bool reserved = world_.grid.At(cell) == kReservedKind;
      world_.grid.Set(cell, reserved ? kEmptyKind : kSmallOrbKind);
    }
  }

  void PlaceLargeOrbs() {
    const int special_quadrant = random_.Int(kQuadrantCount);
    std::array<std::vector<int32_t>, kQuadrantCount> quadrants;
    const int side = figures_.side;
    for (int x = 0; x < side; ++x) {
      for (int y = 0; y < side; ++y) {
        if (world_.grid.At(x, y) == kEmptyKind) {
          // Sides are odd: the middle column and row belong to the lower halves.
          const size_t quadrant = (2 * x > side ? 2U : 0U) + (2 * y > side ? 1U : 0U);
          quadrants[quadrant].push_back(world_.grid.IndexOf(x, y));
        }
      }
    }
    for (int i = 0; i < kQuadrantCount; ++i) {
      const std::vector<int32_t>& cells = quadrants[static_cast<size_t>(i)];
      const int orb_count = i == special_quadrant ? figures_.large_orbs_special_quadrant : 1;
      for (const int32_t index : random_.Distinct(static_cast<int32_t>(cells.size()), orb_count)) {
        const int32_t cell = cells[static_cast<size_t>(index)];
        SpawnAtCell(world_, kLargeOrbKind, kLargeOrbRadius, cell);
        world_.grid.Set(cell, kReservedKind);
      }
    }
  }

  // Agent and eggs stand on small orbs.
  void PlaceAgentAndEggs() {
    std::vector<int32_t> free_cells;
    for (const int32_t cell : open_cells_) {
      if (world_.grid.At(cell) == kEmptyKind) {
        free_cells.push_back(cell);
      }
    }
    small_orbs_left_ = static_cast<int32_t>(free_cells.size());
    const std::vector<int32_t> places =
        random_.Distinct(small_orbs_left_, 1 + figures_.enemy_count);
    const int32_t agent_cell = free_cells[static_cast<size_t>(places[0])];
    Entity& agent = world_.agent();
    agent.rx = kRadius;
    agent.ry = kRadius;
    const int32_t column = agent_cell % figures_.side;
    const int32_t row = agent_cell / figures_.side;
    agent.x = static_cast<float>(column) + 0.5F;
    agent.y = static_cast<float>(row) + 0.5F;
    for (size_t i = 1; i < places.size(); ++i) {
      LayEgg(free_cells[static_cast<size_t>(places[i])]);
    }
  }

  void LayEgg(int32_t cell) { SpawnAtCell(world_, kEggKind, kRadius, cell).health = kHatchSteps; }

  // --- Step.

  bool EnemiesAreEdible() const { return step_number() - large_orb_step_ < kEdibleSteps; }

  void PlayStep() override {
    StandardStep();
    int enemy_count = 0;
    for (size_t i = world_.entities.size(); i-- > 0;) {
      const int kind = world_.entities[i].kind;
      if (kind == kEggKind) {
        ++enemy_count;
        Brood(i);
      } else if (kind == kEnemyKind) {
        ++enemy_count;
        ChooseWay(world_.entities[i]);
      }
    }
    if (enemy_count < figures_.enemy_count) {
      const auto open_count = static_cast<int32_t>(open_cells_.size());
      LayEgg(open_cells_[static_cast<size_t>(world_.shared_random % open_count)]);
    }
    CollectSmallOrb();
  }

  // A component without a control keeps its direction at full speed, even if walls have reduced it.
  // So the agent glides on and can request a turn in advance.
  void UpdateAgentVelocity() override {
    Entity& agent = world_.agent();
    if (world_.controls.horizontal != 0) {
      agent.vx = world_.controls.horizontal;
    }
    if (world_.controls.vertical != 0) {
      agent.vy = world_.controls.vertical;
    }
    agent.vx = static_cast<float>(Sign(agent.vx)) * kAgentSpeed;
    agent.vy = static_cast<float>(Sign(agent.vy)) * kAgentSpeed;
  }

  void Brood(size_t index) {
    Entity& egg = world_.entities[index];
    egg.health -= 1;
    if (egg.health == 0) {
      egg.marked = true;
      SpawnChild(world_, kEnemyKind, kRadius, egg, false).smart = true;
    }
  }

  // An enemy at the center of a cell continues to a neighboring open cell, but not back. In steps
  // with an even random integer it hunts: it chooses among the cells nearest to the agent or, while
  // it is edible, farthest from it.
  void ChooseWay(Entity& enemy) const {
    const auto x = static_cast<float>(enemy.x - 0.5);
    const auto y = static_cast<float>(enemy.y - 0.5);
    const double off_center = std::fabs(x - std::round(static_cast<double>(x))) +
                              std::fabs(y - std::round(static_cast<double>(y)));
    const bool stands = enemy.vx == 0 && enemy.vy == 0;
    if (!stands && off_center >= kCellCenterTolerance) {
      return;
    }
    const auto cell_x = static_cast<int>(x);
    const auto cell_y = static_cast<int>(y);
    const Way back = {.dx = -Sign(enemy.vx), .dy = -Sign(enemy.vy)};
    const bool hunts = world_.shared_random % 2 == 0;
    std::array<Way, 4> ways;
    int way_count = 0;
    int least_cost = 0;
    for (const Way& way : {Way{-1, 0}, Way{0, -1}, Way{0, 1}, Way{1, 0}}) {
      const bool goes_back = way.dx == back.dx && way.dy == back.dy;
      if (!IsOpen(cell_x + way.dx, cell_y + way.dy) || goes_back) {
        continue;
      }
      const int cost = hunts ? HuntingCost(cell_x + way.dx, cell_y + way.dy) : 0;
      if (way_count == 0 || cost < least_cost) {
        way_count = 0;
        least_cost = cost;
      }
      if (cost == least_cost) {
        ways[static_cast<size_t>(way_count)] = way;
        ++way_count;
      }
    }
    if (way_count == 0) {
      return;  // enclosed, which does not occur in levels
    }
    const Way& way = ways[static_cast<size_t>(world_.shared_random % way_count)];
    const float speed = EnemiesAreEdible() ? kEdibleEnemySpeed : kEnemySpeed;
    enemy.vx = (static_cast<float>(cell_x + way.dx) - x) * speed;
    enemy.vy = (static_cast<float>(cell_y + way.dy) - y) * speed;
  }

  bool IsOpen(int x, int y) const {
    return world_.grid.Contains(x, y) && world_.grid.At(x, y) != kMazeWallKind;
  }

  // The distance from a cell to the agent, in cells; negative while fleeing.
  int HuntingCost(int x, int y) const {
    const int distance = std::abs(x - static_cast<int>(world_.agent().x)) +
                         std::abs(y - static_cast<int>(world_.agent().y));
    return EnemiesAreEdible() ? -distance : distance;
  }

  void CollectSmallOrb() {
    const auto x = static_cast<int>(world_.agent().x);
    const auto y = static_cast<int>(world_.agent().y);
    if (world_.CellAt(x, y) == kSmallOrbKind) {
      world_.grid.Set(x, y, kEmptyKind);
      outcome_.reward += kOrbReward;
      --small_orbs_left_;
    }
    if (small_orbs_left_ == 0) {
      outcome_.reward += kCompletionReward;
      outcome_.level_complete = true;
      outcome_.done = true;
    }
  }

  // --- Contacts.

  bool Blocks(const Entity& mover, int kind, Axis axis) override {
    return kind == kMazeWallKind || Game::Blocks(mover, kind, axis);
  }

  void OnAgentContact(Entity& other) override {
    if (other.kind == kLargeOrbKind) {
      large_orb_step_ = step_number();
      outcome_.reward += kOrbReward;
      other.marked = true;
    } else if (other.kind == kEnemyKind) {
      if (EnemiesAreEdible()) {
        other.marked = true;
      } else {
        outcome_.done = true;
      }
    }
  }

  // --- Appearance.

  int ImageKindOf(const Entity& entity) const override {
    if (entity.kind != kEnemyKind) {
      return Game::ImageKindOf(entity);
    }
    if (EnemiesAreEdible()) {
      return kEdibleEnemyImageKind;
    }
    const int frame = step_number() / kFrameSteps;
    return kWingBeat[static_cast<size_t>(frame) % kWingBeat.size()];
  }

  void VisitOwnState(StateArchive& archive) override {
    archive.Int("small_orbs_left", small_orbs_left_, 0, world_.grid.size());
    archive.Int("large_orb_step", large_orb_step_, -kEdibleSteps, kRememberedStepMax);
    // Each egg becomes an enemy, and each enemy's motion tests all others.
    const auto egg_count =
        std::count_if(world_.entities.begin(), world_.entities.end(),
                      [](const Entity& entity) { return entity.kind == kEggKind; });
    archive.Check(egg_count <= kEggCountMax, "has more than 64 eggs");
  }

  const ModeFigures figures_;
  std::vector<int32_t> open_cells_;  // all but walls, in index order
  int32_t small_orbs_left_ = 0;
  int32_t large_orb_step_ = 0;  // step in which a large orb was last taken
};

}  // namespace

extern constexpr GameSpec kChaser = {
    .name = "chaser",
    .description = "The agent collects all orbs of a maze while enemies chase it.",
    .modes = kWithExtreme,
    .easy_returns = {0.5, 13},
    .hard_returns = {0.5, 14.2},
    .kinds = kKinds,
    .make = MakeGame<Chaser>,
};

}  // namespace procgen
