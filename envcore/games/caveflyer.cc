// CaveFlyer: a rocket ship flies through an irregular cave to the goal, a saucer (+10, level
// complete). It turns, and thrusts along its heading; walls only stop it. Touching a meteor, a red
// saucer or a patrolling enemy ship ends the episode. Shots destroy red saucers (five hits, +3);
// meteors and enemy ships absorb them.

#include <algorithm>
#include <cmath>

#include "envcore/games/game.h"
#include "envcore/games/game_spec.h"
#include "envcore/level/caves.h"
#include "envcore/world/contacts.h"
#include "envcore/world/direction.h"
#include "envcore/world/placing.h"

namespace procgen {
namespace {

constexpr int kGoalKind = 1;  // the saucer to reach
constexpr int kMeteorKind = 2;
constexpr int kRedSaucerKind = 3;
constexpr int kShotKind = 4;
constexpr int kEnemyShipKind = 5;
constexpr int kCaveWallKind = 8;  // also everything outside the world
constexpr int kPuffKind = 9;
constexpr int kRouteKind = 1003;  // during level generation

constexpr KindName kKinds[] = {{kGoalKind, "goal_saucer", true},
                               {kMeteorKind, "meteor"},
                               {kRedSaucerKind, "red_saucer"},
                               {kShotKind, "shot"},
                               {kEnemyShipKind, "enemy_ship"},
                               {kCaveWallKind, "cave_wall"},
                               {kPuffKind, "exhaust"}};

constexpr SpecialAction kSpecialActions[] = {{9, "Fires a shot where the ship points."}};

constexpr int kWorldSideEasy = 30;  // cells
constexpr int kWorldSideHard = 40;
constexpr int kWorldSideMemory = 60;
constexpr float kCellsInViewEasy = 10;
constexpr float kCellsInView = 16;

constexpr double kWallShare = 0.5;  // of the noise that the cave is generated from
constexpr int kSmoothings = 4;
constexpr int kRouteMargin = 4;      // cells of the cave that are kept beside the route
constexpr int kCellsPerObject = 80;  // free cells per meteor, red saucer and enemy ship

constexpr float kRadius = 0.5F;  // of goal, meteors, saucers and ships, cells
constexpr float kSaucerHealth = 5;
constexpr double kShipSpeedMin = 0.1;  // cells per step
constexpr double kShipSpeedRange = 0.1;

constexpr float kForwardThrust = 1;
constexpr float kBackwardThrust = -0.33F;
constexpr float kThrustSpeed = 0.9F * 0.5F;  // cells per step
constexpr double kThrustShare = 0.2;         // of kThrustSpeed, gained per step
constexpr double kVelocityDecay = 0.9;

constexpr float kPuffShare = 0.5F;  // of the ship's half-size
constexpr float kPuffGrowth = 1.25F;
constexpr float kPuffFading = 0.8F;
constexpr int kPuffExpiry = 4;  // steps

constexpr float kShotRadiusX = 0.1F;  // cells
constexpr float kShotRadiusY = 0.25F;
constexpr int kShotExpiry = 10;          // steps; the speed is 1 cell per step
constexpr float kExplosionShare = 0.5F;  // of the half-width of the exploding entity

constexpr float kGoalReward = 10;
constexpr float kSaucerReward = 3;

constexpr ArtSlot kArtSlots[] = {
    {0, 0, "ship", "misc_assets/playerShip1_red.png", 99, 75},
    {1, 0, "goal_saucer", "misc_assets/ufoGreen2.png", 91, 91},
    {2, 0, "meteor", "misc_assets/meteorBrown_big1.png", 101, 84},
    {3, 0, "red_saucer", "misc_assets/ufoRed2.png", 91, 91},
    {4, 0, "shot", "misc_assets/laserBlue02.png", 13, 37},
    {5, 0, "enemy_ship", "misc_assets/enemyShipBlue4.png", 82, 84},
    {8, 0, "cave_wall", "misc_assets/groundA.png", 128, 128},
    {9, 0, "exhaust", "misc_assets/towerDefense_tile295.png", 60, 60},
};

constexpr int kBlockShapedKinds[] = {kCaveWallKind};

constexpr GameArtSpec kArt = {.slots = kArtSlots,
                              .block_shaped_kinds = kBlockShapedKinds,
                              .background_group = BackgroundGroup::kSpace};

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

bool IsLethal(int kind) {
  return kind == kMeteorKind || kind == kRedSaucerKind || kind == kEnemyShipKind;
}

class CaveFlyer final : public Game {
 public:
  explicit CaveFlyer(const GameOptions& options) : Game(kArt, options) {
    const bool easy = options.distribution_mode == DistributionMode::kEasy;
    cells_in_view_ = easy ? kCellsInViewEasy : kCellsInView;
    world_.out_of_bounds_kind = kCaveWallKind;
  }

 private:
  // --- Level generation: a cave, a route through it from the ship to the goal, and dangers beside
  // the route.

  void MakeLevel() override {
    const int side = WorldSide(options().distribution_mode);
    StandardReset(side, side);
    const std::vector<int32_t> free_cells = DigCave();
    const std::vector<int32_t> ends = random_.Distinct(static_cast<int32_t>(free_cells.size()), 2);
    const int agent_cell = free_cells[static_cast<size_t>(ends[0])];
    const int goal_cell = free_cells[static_cast<size_t>(ends[1])];
    Entity& agent = world_.agent();
    const int agent_row = agent_cell / side;
    agent.x = static_cast<float>(agent_cell % side) + 0.5F;
    agent.y = static_cast<float>(agent_row) + 0.5F;
    Entity& goal = SpawnAtCell(world_, kGoalKind, kRadius, goal_cell);
    goal.meets_entities = true;

    const std::vector<int32_t> route = FindPath(world_.grid, agent_cell, goal_cell);
    if (options().distribution_mode != DistributionMode::kMemory) {
      KeepOnly(Widened(world_.grid, route, kRouteMargin));
    }
    for (int i = 0; i < kSmoothings; ++i) {
      SmoothCave(world_.grid);
      SetAll(route, kEmptyKind);
    }
    SetAll(route, kRouteKind);
    PlaceDangers();
    SetAll(route, kEmptyKind);
  }

  // Smooths noise into caverns and keeps the largest. Returns its cells.
  std::vector<int32_t> DigCave() {
    Grid& grid = world_.grid;
    for (int cell = 0; cell < grid.size(); ++cell) {
      const double noise = random_.Unit();
      grid.Set(cell, noise < kWallShare ? kWallKind : kEmptyKind);
    }
    for (int i = 0; i < kSmoothings; ++i) {
      SmoothCave(grid);
    }
    std::vector<int32_t> room = BestRoom(grid);
    KeepOnly(room);
    return room;
  }

  void KeepOnly(const std::vector<int32_t>& cells) {
    Grid& grid = world_.grid;
    grid.Fill(0, 0, grid.width(), grid.height(), kWallKind);
    SetAll(cells, kEmptyKind);
  }

  void SetAll(const std::vector<int32_t>& cells, int kind) {
    for (const int32_t cell : cells) {
      world_.grid.Set(cell, kind);
    }
  }

  // Replaces the wall kind and places meteors, red saucers and enemy ships, equally many of each,
  // in the open cells.
  void PlaceDangers() {
    Grid& grid = world_.grid;
    std::vector<int32_t> free_cells;
    for (int cell = 0; cell < grid.size(); ++cell) {
      if (grid.At(cell) == kEmptyKind) {
        free_cells.push_back(cell);
      } else if (grid.At(cell) == kWallKind) {
        grid.Set(cell, kCaveWallKind);
      }
    }
    const auto free_count = static_cast<int32_t>(free_cells.size());
    const int32_t count = free_count / kCellsPerObject;
    const std::vector<int32_t> places = random_.Distinct(free_count, 3 * count);
    for (int32_t i = 0; i < 3 * count; ++i) {
      const int32_t cell = free_cells[static_cast<size_t>(places[static_cast<size_t>(i)])];
      if (i < count) {
        SpawnAtCell(world_, kMeteorKind, kRadius, cell).meets_entities = true;
      } else if (i < 2 * count) {
        PlaceRedSaucer(cell);
      } else {
        PlaceEnemyShip(cell);
      }
    }
  }

  void PlaceRedSaucer(int32_t cell) {
    Entity& saucer = SpawnAtCell(world_, kRedSaucerKind, kRadius, cell);
    saucer.meets_entities = true;
    saucer.health = kSaucerHealth;
  }

  void PlaceEnemyShip(int32_t cell) {
    Entity& ship = SpawnAtCell(world_, kEnemyShipKind, kRadius, cell);
    ship.meets_entities = true;
    ship.smart = true;
    const double speed_share = random_.Unit();
    const int32_t direction = random_.Int(2) * 2 - 1;
    const auto velocity =
        static_cast<float>((kShipSpeedRange * speed_share + kShipSpeedMin) * direction);
    const bool horizontal = random_.Unit() < 0.5F;
    (horizontal ? ship.vx : ship.vy) = velocity;
  }

  // --- Step.

  void PlayStep() override {
    StandardStep();
    if (special_action_ == 1) {
      Shoot();
    }
    for (size_t i = world_.entities.size(); i-- > 0;) {
      Entity& entity = world_.entities[i];
      if (entity.kind == kEnemyShipKind) {
        TurnTo(entity, entity.vx, entity.vy, -kHalfPi);
      } else if (entity.kind == kShotKind && IsInWall(entity)) {
        entity.marked = true;
        SpawnChild(world_, kExplosionKind, kExplosionShare * entity.rx, entity, false);
      }
    }
    RemoveGone(world_);
  }

  // Left and right turn the ship. Up and down thrust along the heading before the turn.
  void MapControls() override {
    Controls& controls = world_.controls;
    const double heading = kHalfPi - world_.agent().rotation;
    float thrust = 0;
    if (controls.vertical > 0) {
      thrust = kForwardThrust;
      BlowExhaust(heading);
    } else if (controls.vertical < 0) {
      thrust = kBackwardThrust;
    }
    controls.turn = controls.horizontal;
    controls.horizontal = static_cast<float>(thrust * std::cos(heading));
    controls.vertical = static_cast<float>(thrust * std::sin(heading));
  }

  void BlowExhaust(double heading) {
    const Entity& agent = world_.agent();
    const auto x = static_cast<float>(agent.x - agent.rx * std::cos(heading));
    const auto y = static_cast<float>(agent.y - agent.ry * std::sin(heading));
    const float radius = kPuffShare * agent.rx;
    Entity& puff =
        world_.entities.emplace_back(Entity::Make(kPuffKind, x, y, 0, 0, radius, radius));
    puff.expiry = kPuffExpiry;
    puff.growth = kPuffGrowth;
    puff.fading = kPuffFading;
    puff.rotation = -static_cast<float>(heading) - kHalfPi;
  }

  void UpdateAgentVelocity() override {
    Entity& agent = world_.agent();
    agent.vx = Accelerated(agent.vx, world_.controls.horizontal);
    agent.vy = Accelerated(agent.vy, world_.controls.vertical);
  }

  // A velocity after one step of thrust and drag, rounded to f32 after thrust.
  float Accelerated(float velocity, float control) const {
    const float thrust_speed = thrust_speed_ * control;
    const auto accelerated = static_cast<float>(velocity + thrust_speed * kThrustShare);
    return static_cast<float>(kVelocityDecay * accelerated);
  }

  void Shoot() {
    const Entity& agent = world_.agent();
    const float rotation = agent.rotation;
    const double heading = kHalfPi - rotation;
    const auto vx = static_cast<float>(std::cos(heading));
    const auto vy = static_cast<float>(std::sin(heading));
    Entity& shot = world_.entities.emplace_back(
        Entity::Make(kShotKind, agent.x, agent.y, vx, vy, kShotRadiusX, kShotRadiusY));
    shot.expiry = kShotExpiry;
    shot.rotation = rotation;
  }

  // Whether a corner of the box, without rotation, is in a wall or outside the world.
  bool IsInWall(const Entity& entity) const {
    const float left = entity.x - entity.rx;
    const float right = entity.x + entity.rx;
    const float bottom = entity.y - entity.ry;
    const float top = entity.y + entity.ry;
    return world_.CellAtPoint(left, bottom) == kCaveWallKind ||
           world_.CellAtPoint(left, top) == kCaveWallKind ||
           world_.CellAtPoint(right, bottom) == kCaveWallKind ||
           world_.CellAtPoint(right, top) == kCaveWallKind;
  }

  // --- Contacts.

  bool Reflects(const Entity& mover, int kind) override {
    return mover.kind == kEnemyShipKind && kind == kCaveWallKind;
  }

  void OnAgentContact(Entity& other) override {
    if (other.kind == kGoalKind) {
      outcome_.reward += kGoalReward;
      outcome_.level_complete = true;
      outcome_.done = true;
    } else if (IsLethal(other.kind)) {
      outcome_.done = true;
    }
  }

  // The goal and the dangers test for shots. The explosion of a shot moves with the velocity of the
  // entity that was hit.
  void OnEntityContact(Entity& self, Entity& other) override {
    if (other.kind != kShotKind) {
      return;
    }
    other.marked = true;
    const float radius = kExplosionShare * other.rx;
    const Entity impact =
        Entity::Make(kExplosionKind, other.x, other.y, self.vx, self.vy, radius, radius);
    if (self.kind == kRedSaucerKind) {
      self.health -= 1;
      if (self.health <= 0) {
        self.marked = true;
        outcome_.reward += kSaucerReward;
        SpawnChild(world_, kExplosionKind, kExplosionShare * self.rx, self, false);
      }
    }
    world_.entities.push_back(impact);
  }

  const float thrust_speed_ = ValueOf(Variant::kThrustSpeed, kThrustSpeed);
};

}  // namespace

extern constexpr GameSpec kCaveFlyer = {
    .name = "caveflyer",
    .description = "A ship flies through caves to its friend and shoots what is in the way.",
    .modes = kWithMemory,
    .easy_returns = {3.5, 12},
    .hard_returns = {2, 13.4},
    .exploration_level = 1259048185,
    .special_actions = kSpecialActions,
    .kinds = kKinds,
    .make = MakeGame<CaveFlyer>,
};

}  // namespace procgen
