// Jumper: a bunny with a double jump searches for a carrot in an open cave (+10, level complete).
// Little men with a spike on the head stand on flat ground; touching one ends the episode. A
// compass in the corner shows the carrot's direction and distance, except in memory mode.

#include <cmath>
#include <vector>

#include "envcore/games/game.h"
#include "envcore/games/game_spec.h"
#include "envcore/level/caves.h"
#include "envcore/level/maze.h"
#include "envcore/world/placing.h"
#include "envcore/world/support.h"
#include "envcore/world/world_state.h"

namespace procgen {
namespace {

constexpr int kCarrotKind = 1;
constexpr int kSpikeManKind = 2;         // also marks its cell during level generation
constexpr int kRockKind = 6;             // also everything outside the world
constexpr int kGroundKind = 7;           // rock with open space above
constexpr int kLeftApartImageKind = 10;  // image kinds: the bunny's walk, legs apart and together
constexpr int kLeftTogetherImageKind = 11;
constexpr int kRightApartImageKind = 12;
constexpr int kRightTogetherImageKind = 13;

constexpr KindName kKinds[] = {{kCarrotKind, "carrot", true},
                               {kSpikeManKind, "spike_man"},
                               {kRockKind, "rock"},
                               {kGroundKind, "ground"}};

constexpr float kAgentRadiusX = 0.254F;  // cells
constexpr float kAgentRadiusY = 0.4F;
constexpr float kSpikeManRadiusX = 0.23F;
constexpr float kSpikeManRadiusY = 0.4F;
constexpr float kCarrotRadius = 0.5F;

constexpr int kMazeScale = 3;             // side of a maze cell in cells; the maze shapes the cave
constexpr float kWallShareInWall = 0.8F;  // of the noise where the maze has a wall
constexpr float kWallShareInOpen = 0.2F;  // of the noise where it is open
constexpr int kSmoothings = 2;
constexpr int kWayMargin = 4;  // cells of the cave that are kept beside the way to the carrot
constexpr float kSpikeManChance = 0.2F;  // per possible place
constexpr int kHighWall = 3;             // rows of rock that could trap the bunny
constexpr int kWallThemeCount = 4;

constexpr float kMix = 0.5F;       // weight of the new velocity
constexpr float kTopSpeed = 0.5F;  // cells per step
constexpr float kJumpVelocity = 1;
constexpr float kGravity = 0.15F;   // cells per step, in each step
constexpr float kFallSpeedMax = 2;  // gravity adds nothing beyond this
constexpr int kJumpsFromSupport = 2;
constexpr int kJumpPauseSteps = 3;  // a jump is possible more than this many steps after the last
constexpr double kDustSpeedMin = 0.05;  // a faster bunny raises dust
constexpr float kCarrotReward = 10;
constexpr int kFrameSteps = 5;           // steps per frame of a walk
constexpr double kStandingSpeed = 0.01;  // slower counts as standing

constexpr float kCompassMargin = 0.25F;  // cells from the upper right corner of the image
constexpr float kCompassBarShare = 8;    // height of the compass / height of its distance bar
constexpr std::array<uint8_t, 3> kCompassColor = {168, 166, 158};
constexpr std::array<uint8_t, 3> kNeedleColor = {252, 186, 3};

struct ModeFigures {
  int world_side;  // cells
  float cells_in_view;
  float compass_diameter;   // cells; 0: no compass
  float spike_man_chance;   // per possible place
  bool only_way_to_carrot;  // the cave is reduced to the surroundings of the way to the carrot
};

constexpr ModeFigures kEasyFigures = {.world_side = 20,
                                      .cells_in_view = 12,
                                      .compass_diameter = 3,
                                      .spike_man_chance = kSpikeManChance,
                                      .only_way_to_carrot = true};
constexpr ModeFigures kHardFigures = {.world_side = 40,
                                      .cells_in_view = 16,
                                      .compass_diameter = 2,
                                      .spike_man_chance = kSpikeManChance,
                                      .only_way_to_carrot = true};
constexpr ModeFigures kMemoryFigures = {.world_side = 45,
                                        .cells_in_view = 16,
                                        .compass_diameter = 0,
                                        .spike_man_chance = 0,
                                        .only_way_to_carrot = false};

constexpr ArtSlot kArtSlots[] = {
    {0, 0, "bunny_stand", "misc_assets/bunny2_ready.png", 121, 191},
    {1, 0, "carrot", "misc_assets/carrot.png", 78, 70},
    {2, 0, "spike_man", "misc_assets/spikeMan_stand.png", 90, 155},
    {6, 0, "rock", "platformer/tileBlue_08.png", 64, 64},
    {6, 1, "rock", "platformer/tileGreen_08.png", 64, 64},
    {6, 2, "rock", "platformer/tileYellow_09.png", 64, 64},
    {6, 3, "rock", "platformer/tileBrown_09.png", 64, 64},
    {7, 0, "ground", "platformer/tileBlue_05.png", 64, 64},
    {7, 1, "ground", "platformer/tileGreen_05.png", 64, 64},
    {7, 2, "ground", "platformer/tileYellow_06.png", 64, 64},
    {7, 3, "ground", "platformer/tileBrown_06.png", 64, 53},
    {9, 0, "bunny_jump", "misc_assets/bunny2_jump.png", 150, 181},
    {10, 0, "bunny_walk_apart", "misc_assets/bunny2_walk1.png", 121, 201},
    {11, 0, "bunny_walk_together", "misc_assets/bunny2_walk2.png", 121, 207},
    {12, 0, "bunny_walk_apart", "misc_assets/bunny2_walk1.png", 121, 201},
    {13, 0, "bunny_walk_together", "misc_assets/bunny2_walk2.png", 121, 207},
};

constexpr int kBlockShapedKinds[] = {kRockKind, kGroundKind};

constexpr GameArtSpec kArt = {.slots = kArtSlots,
                              .block_shaped_kinds = kBlockShapedKinds,
                              .background_group = BackgroundGroup::kPlatform};

const ModeFigures& FiguresOf(DistributionMode mode) {
  switch (mode) {
    case DistributionMode::kEasy:
      return kEasyFigures;
    case DistributionMode::kMemory:
      return kMemoryFigures;
    default:
      return kHardFigures;
  }
}

bool IsSolid(int kind) { return kind == kRockKind || kind == kGroundKind; }

class Jumper final : public Game {
 public:
  explicit Jumper(const GameOptions& options)
      : Game(kArt, options), figures_(FiguresOf(options.distribution_mode)) {
    cells_in_view_ = figures_.cells_in_view;
    top_speed_ = kTopSpeed;
    world_.out_of_bounds_kind = kRockKind;
  }

 private:
  // --- Level generation: a cave in the shape of a maze, a way through it from the bunny to the
  // carrot, spike men on flat ground, steps in high walls.

  void MakeLevel() override {
    StandardReset(figures_.world_side, figures_.world_side);
    const int wall_theme = random_.Int(kWallThemeCount);
    cell_looks_[kRockKind].theme = static_cast<int16_t>(wall_theme);
    cell_looks_[kGroundKind].theme = static_cast<int16_t>(wall_theme);
    jumps_left_ = 0;
    last_jump_step_ = 0;
    has_support_ = false;
    jumped_ = false;

    Grid& grid = world_.grid;
    const std::vector<int32_t> cave = DigCave();
    const int32_t carrot_cell = random_.OneOf(cave);
    const int32_t start_cell = random_.OneOf(GroundPlaces());
    const std::vector<int32_t> way = FindPath(grid, start_cell, carrot_cell);
    if (figures_.only_way_to_carrot) {
      KeepOnly(Widened(grid, way, kWayMargin));
    }
    SpawnAtCell(world_, kCarrotKind, kCarrotRadius, carrot_cell).auto_remove = false;
    MarkSpikeMen();
    BreakHighWalls();
    Entity& agent = world_.agent();
    agent.rx = kAgentRadiusX;
    agent.ry = kAgentRadiusY;
    StandIn(agent, start_cell);
    SpawnSpikeMen();
    CoverGround();
  }

  // Fills the world with noise that is denser where a maze has walls, smooths it and keeps the
  // largest cave. Returns its cells.
  std::vector<int32_t> DigCave() {
    Grid& grid = world_.grid;
    const int side = figures_.world_side;
    Maze maze(side / kMazeScale);
    maze.MakeWithoutDeadEnds(random_);
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x) {
        const bool is_wall = IsWallOf(maze, x / kMazeScale, y / kMazeScale);
        const float noise = random_.Unit();
        grid.Set(x, y,
                 noise < (is_wall ? kWallShareInWall : kWallShareInOpen) ? kWallKind : kEmptyKind);
      }
    }
    for (int i = 0; i < kSmoothings; ++i) {
      SmoothCave(grid);
    }
    grid.Fill(0, 0, side, 1, kRockKind);
    grid.Fill(0, side - 1, side, 1, kRockKind);
    grid.Fill(0, 0, 1, side, kRockKind);
    grid.Fill(side - 1, 0, 1, side, kRockKind);
    std::vector<int32_t> cave = BestRoom(grid);
    KeepOnly(cave);
    return cave;
  }

  // The maze does not cover the last cells if the side of the world is not a multiple of the scale.
  static bool IsWallOf(const Maze& maze, int x, int y) {
    return x >= maze.size() || y >= maze.size() || maze.At(x, y) == kWallKind;
  }

  // Makes all other cells rock.
  void KeepOnly(const std::vector<int32_t>& cells) {
    Grid& grid = world_.grid;
    grid.Fill(0, 0, grid.width(), grid.height(), kRockKind);
    for (const int32_t cell : cells) {
      grid.Set(cell, kEmptyKind);
    }
  }

  // Whether an object two cells high can stand in the cell.
  bool IsGroundPlace(int x, int y) const {
    return world_.CellAt(x, y) == kEmptyKind && world_.CellAt(x, y + 1) == kEmptyKind &&
           world_.CellAt(x, y - 1) == kRockKind;
  }

  std::vector<int32_t> GroundPlaces() const {
    std::vector<int32_t> places;
    for (int cell = 0; cell < world_.grid.size(); ++cell) {
      if (IsGroundPlace(cell % world_.grid.width(), cell / world_.grid.width())) {
        places.push_back(cell);
      }
    }
    return places;
  }

  // Spike men need ground on both sides. A marked cell is not empty, so no two stand side by side.
  // The cells of the agent and the carrot are not excluded.
  void MarkSpikeMen() {
    Grid& grid = world_.grid;
    for (int cell = 0; cell < grid.size(); ++cell) {
      const int x = cell % grid.width();
      const int y = cell / grid.width();
      if (IsGroundPlace(x, y) && IsGroundPlace(x - 1, y) && IsGroundPlace(x + 1, y)) {
        if (random_.Unit() < figures_.spike_man_chance) {
          grid.Set(cell, kSpikeManKind);
        }
      }
    }
  }

  // Opens one cell of each wall that is too high to climb.
  void BreakHighWalls() {
    for (int y = 0; y + kHighWall <= world_.grid.height(); ++y) {
      for (int x = 0; x < world_.grid.width(); ++x) {
        for (const int side : {1, -1}) {
          if (IsHighWall(x, y, side)) {
            const int height = random_.Int(kHighWall);
            world_.grid.Set(x, y + height, kEmptyKind);
          }
        }
      }
    }
  }

  // Whether three cells of rock from (x, y) upward have empty cells on one side (1: right).
  bool IsHighWall(int x, int y, int side) const {
    for (int i = 0; i < kHighWall; ++i) {
      if (world_.CellAt(x, y + i) != kRockKind || world_.CellAt(x + side, y + i) != kEmptyKind) {
        return false;
      }
    }
    return true;
  }

  void StandIn(Entity& entity, int32_t cell) const {
    const int row = cell / world_.grid.width();
    entity.x = static_cast<float>(cell % world_.grid.width()) + 0.5F;
    entity.y = static_cast<float>(row) + entity.ry;
  }

  void SpawnSpikeMen() {
    Grid& grid = world_.grid;
    for (int cell = 0; cell < grid.size(); ++cell) {
      if (grid.At(cell) == kSpikeManKind) {
        grid.Set(cell, kEmptyKind);
        Entity& spike_man = world_.entities.emplace_back(
            Entity::Make(kSpikeManKind, 0, 0, 0, 0, kSpikeManRadiusX, kSpikeManRadiusY));
        StandIn(spike_man, cell);
      }
    }
  }

  void CoverGround() {
    Grid& grid = world_.grid;
    for (int y = 0; y < grid.height(); ++y) {
      for (int x = 0; x < grid.width(); ++x) {
        if (grid.At(x, y) == kRockKind && world_.CellAt(x, y + 1) == kEmptyKind) {
          grid.Set(x, y, kGroundKind);
        }
      }
    }
  }

  // --- Step.

  void PlayStep() override {
    StandardStep();
    Entity& agent = world_.agent();
    if (world_.controls.horizontal != 0) {
      agent.mirrored = world_.controls.horizontal < 0;
    }
    const double speed =
        std::fabs(static_cast<double>(agent.vx)) + std::fabs(static_cast<double>(agent.vy));
    if (agent.vy > -kFallSpeedMax) {
      agent.vy -= gravity_;
    }
    if (speed > kDustSpeedMin) {
      SpawnDust(world_, agent);
    }
  }

  // Up jumps, with support and once more in the air, but not immediately again.
  void MapControls() override {
    has_support_ = StandsOn(world_, world_.agent(), IsSolid);
    if (has_support_) {
      jumps_left_ = kJumpsFromSupport;
    }
    jumped_ = world_.controls.vertical > 0 && jumps_left_ > 0 &&
              step_number() - last_jump_step_ > kJumpPauseSteps;
    world_.controls.vertical = jumped_ ? 1 : 0;
    if (jumped_) {
      --jumps_left_;
      last_jump_step_ = step_number();
    }
  }

  void UpdateAgentVelocity() override {
    Entity& agent = world_.agent();
    agent.vx = (1 - kMix) * agent.vx + (kMix * kTopSpeed) * world_.controls.horizontal;
    if (jumped_) {
      agent.vy = takeoff_speed_;
    }
  }

  // --- Contacts.

  bool Blocks(const Entity& mover, int kind, Axis axis) override {
    return kind == kGroundKind || Game::Blocks(mover, kind, axis);
  }

  void OnAgentContact(Entity& other) override {
    if (other.kind == kCarrotKind) {
      outcome_.reward += kCarrotReward;
      outcome_.level_complete = true;
      outcome_.done = true;
    } else if (other.kind == kSpikeManKind) {
      outcome_.done = true;
    }
  }

  // --- Appearance.

  int ImageKindOf(const Entity& entity) const override {
    if (entity.kind != kAgentKind) {
      return Game::ImageKindOf(entity);
    }
    if (std::fabs(entity.vx) < kStandingSpeed && world_.controls.horizontal == 0 && has_support_) {
      return kAgentKind;
    }
    if ((step_number() / kFrameSteps) % 2 == 0 || !has_support_) {
      return entity.mirrored ? kLeftApartImageKind : kRightApartImageKind;
    }
    return entity.mirrored ? kLeftTogetherImageKind : kRightTogetherImageKind;
  }

  void AddOverlays(std::vector<Overlay>* overlays) const override {
    if (figures_.compass_diameter > 0) {
      AddCompass(overlays);
    }
  }

  // A disc with a needle that points to the carrot, and a bar below it that shows the distance.
  // Also a mark below a bunny that jumps in the air.
  void AddCompass(std::vector<Overlay>* overlays) const {
    const Entity& agent = world_.agent();
    const Entity& carrot = world_.entities[kCarrotIndex];
    const float diameter = figures_.compass_diameter;
    const float dx = carrot.x - agent.x;
    const float dy = carrot.y - agent.y;
    Overlay disc = {.shape = Overlay::Shape::kDisc,
                    .x = (MakeCamera().cells - diameter) - kCompassMargin,
                    .y = kCompassMargin,
                    .width = diameter,
                    .height = diameter,
                    .color = kCompassColor};
    overlays->push_back(disc);

    Overlay needle = disc;
    needle.shape = Overlay::Shape::kNeedle;
    needle.angle = static_cast<float>(std::atan2(static_cast<double>(dy), static_cast<double>(dx)));
    needle.color = kNeedleColor;
    overlays->push_back(needle);

    const auto distance_share =
        static_cast<float>(Distance(agent, carrot) / (figures_.world_side * std::sqrt(2.0)));
    Overlay bar = disc;
    bar.shape = Overlay::Shape::kRectangle;
    bar.y = kCompassMargin + diameter;
    bar.width = diameter * distance_share;
    bar.height = diameter / kCompassBarShare;
    bar.color = kNeedleColor;
    overlays->push_back(bar);

    if (jumped_ && !has_support_) {
      overlays->push_back({.shape = Overlay::Shape::kJumpMark,
                           .x = agent.x,
                           .y = agent.y,
                           .width = agent.rx,
                           .height = agent.ry});
    }
  }

  void VisitOwnState(StateArchive& archive) override {
    archive.Int("jumps_left", jumps_left_, 0, kJumpsFromSupport);
    archive.Int("last_jump_step", last_jump_step_, 0, kRememberedStepMax);
    archive.Bool("jumped", jumped_);
    archive.Bool("has_support", has_support_);
    archive.Check(world_.entities.size() > kCarrotIndex &&
                      IsThereForGood(world_.entities[kCarrotIndex], kCarrotKind),
                  "has no carrot that stays, as entity 1");
  }

  // The carrot's index in the list of entities: it is added first and never removed.
  static constexpr size_t kCarrotIndex = 1;

  const ModeFigures& figures_;
  int32_t jumps_left_ = 0;
  int32_t last_jump_step_ = 0;
  bool jumped_ = false;       // in the last step
  bool has_support_ = false;  // computed in MapControls of the last step
  const float gravity_ = ValueOf(Variant::kGravity, kGravity);
  const float takeoff_speed_ = ValueOf(Variant::kJumpSpeed, kJumpVelocity);
};

}  // namespace

extern constexpr GameSpec kJumper = {
    .name = "jumper",
    .description = "A bunny double-jumps through caves to the carrot that a compass points to.",
    .modes = kWithMemory,
    .step_limit_memory = 2000,
    .easy_returns = {3, 10},
    .hard_returns = {1, 10},
    .exploration_level = 1434825276,
    .kinds = kKinds,
    .make = MakeGame<Jumper>,
};

}  // namespace procgen
