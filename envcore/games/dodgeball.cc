// Dodgeball: the agent runs through a hall with free-standing walls of lava, throws balls at the
// enemies (+2 per hit) and dodges theirs. When no enemy is left, the door opens (+10, level
// complete). Touching an enemy, an enemy's ball or lava ends the episode.

#include <array>
#include <cmath>
#include <vector>

#include "envcore/games/game.h"
#include "envcore/games/game_spec.h"
#include "envcore/world/contacts.h"
#include "envcore/world/direction.h"
#include "envcore/world/placing.h"
#include "envcore/world/world_state.h"

namespace procgen {
namespace {

constexpr int kLavaKind = 1;
constexpr int kBallKind = 3;
constexpr int kEnemyKind = 4;
constexpr int kDoorKind = 5;
constexpr int kEnemyBallKind = 6;
constexpr int kOpenDoorImageKind = 7;
constexpr int kCloudKind = 8;
constexpr int kHallOutsideKind = 10;

constexpr KindName kKinds[] = {{kLavaKind, "lava"},
                               {kBallKind, "ball"},
                               {kEnemyKind, "enemy"},
                               {kDoorKind, "door", true},
                               {kEnemyBallKind, "enemy_ball"},
                               {kCloudKind, "cloud"},
                               {kHallOutsideKind, "outside"}};

constexpr SpecialAction kSpecialActions[] = {
    {9, "Throws a ball in the direction of the last move, at most once in 7 steps."}};

constexpr float kLavaRadius = 0.3F;     // half the thickness of a wall, before the mode's factor
constexpr float kEnemySpeed = 0.05F;    // cells per step
constexpr int kEnemyWalkStepsMin = 25;  // steps in one direction
constexpr int kEnemyWalkStepsRange = 50;
constexpr int kEnemyThrowPause = 50;  // steps, plus a random number
constexpr int kEnemyThrowPauseRange = 4;
constexpr int kEnemyFirstShotStep = 10;   // as if it had thrown in this step
constexpr float kAimTolerance = 1;        // cells beside the agent at which an enemy throws
constexpr int kThrowPause = 7;            // least steps from one throw of the agent to the next
constexpr int32_t kThrowAction = 1;       // special action
constexpr int kBallLife = 50;             // steps
constexpr float kBallSpin = kPi * 0.23F;  // radians per step
constexpr int kCloudLife = 4;             // steps
constexpr float kCloudSpin = kPi / 0.3F;
constexpr float kCloudGrowth = 1 / 1.2F;  // factors per step
constexpr float kCloudFading = 0.9F;
constexpr int kEnemyCountMin = 3;
constexpr int kEnemyThemesUsed = 7;  // of the eleven in the art
constexpr float kHitReward = 2;
constexpr float kDoorReward = 10;

constexpr ArtSlot kArtSlots[] = {
    {0, 0, "thrower", "misc_assets/character12.png", 38, 43},
    {1, 0, "lava", "misc_assets/tileStone_slope2.png", 12, 12},
    {3, 0, "ball", "misc_assets/ball_soccer1.png", 18, 18},
    {4, 0, "enemy", "misc_assets/character1.png", 35, 43},
    {4, 1, "enemy", "misc_assets/character2.png", 35, 43},
    {4, 2, "enemy", "misc_assets/character3.png", 35, 43},
    {4, 3, "enemy", "misc_assets/character4.png", 35, 43},
    {4, 4, "enemy", "misc_assets/character5.png", 35, 43},
    {4, 5, "enemy", "misc_assets/character6.png", 35, 43},
    {4, 6, "enemy", "misc_assets/character7.png", 35, 43},
    {4, 7, "enemy", "misc_assets/character8.png", 35, 43},
    {4, 8, "enemy", "misc_assets/character9.png", 38, 43},
    {4, 9, "enemy", "misc_assets/character10.png", 38, 43},
    {4, 10, "enemy", "misc_assets/character11.png", 38, 43},
    {5, 0, "door_closed", "misc_assets/blockRed.png", 64, 64},
    {6, 0, "enemy_ball", "misc_assets/ball_soccer2.png", 18, 18},
    {7, 0, "door_open", "misc_assets/blockGreen.png", 64, 64},
    {8, 0, "cloud", "misc_assets/spaceEffect1.png", 41, 42},
    {8, 1, "cloud", "misc_assets/spaceEffect2.png", 56, 49},
    {8, 2, "cloud", "misc_assets/spaceEffect3.png", 59, 55},
    {8, 3, "cloud", "misc_assets/spaceEffect4.png", 52, 50},
    {8, 4, "cloud", "misc_assets/spaceEffect5.png", 63, 65},
    {8, 5, "cloud", "misc_assets/spaceEffect6.png", 73, 72},
    {8, 6, "cloud", "misc_assets/spaceEffect7.png", 87, 100},
    {8, 7, "cloud", "misc_assets/spaceEffect8.png", 100, 102},
    {8, 8, "cloud", "misc_assets/spaceEffect9.png", 69, 71},
    {10, 0, "outside", "misc_assets/tileStone_slope2.png", 12, 12},
};

constexpr int kBlockShapedKinds[] = {kLavaKind, kDoorKind, kOpenDoorImageKind};

constexpr GameArtSpec kArt = {.slots = kArtSlots,
                              .block_shaped_kinds = kBlockShapedKinds,
                              .background_group = BackgroundGroup::kTopdown};

struct ModeFigures {
  int side;            // of the hall, cells
  float agent_radius;  // cells
  float agent_speed;   // cells per step, like the other speeds
  float enemy_radius;
  float ball_radius;
  float ball_speed;  // on each axis
  float door_radius;
  float lava_radius;        // half the thickness of a wall
  int division_count;       // number of walls that divide rooms
  int enemy_count_choices;  // kEnemyCountMin and up
};

constexpr ModeFigures kHardFigures = {.side = 20,
                                      .agent_radius = 0.75F,
                                      .agent_speed = 0.5F,
                                      .enemy_radius = 0.75F,
                                      .ball_radius = 0.375F,
                                      .ball_speed = 0.375F,
                                      .door_radius = 0.75F,
                                      .lava_radius = static_cast<float>(kLavaRadius * 1.5),
                                      .division_count = 4,
                                      .enemy_count_choices = 4};

constexpr ModeFigures kEasyFigures = {.side = 20,
                                      .agent_radius = 1,
                                      .agent_speed = 0.75F,
                                      .enemy_radius = 1,
                                      .ball_radius = 0.5F,
                                      .ball_speed = 0.5F,
                                      .door_radius = 1.5F,
                                      .lava_radius = kLavaRadius * 2,
                                      .division_count = 2,
                                      .enemy_count_choices = 4};

constexpr ModeFigures kExtremeFigures = {.side = 20,
                                         .agent_radius = 0.4F,
                                         .agent_speed = 0.25F,
                                         .enemy_radius = 0.5F,
                                         .ball_radius = 0.25F,
                                         .ball_speed = 0.25F,
                                         .door_radius = 0.75F,
                                         .lava_radius = kLavaRadius,
                                         .division_count = 8,
                                         .enemy_count_choices = 4};

// A hall like in hard mode, but twice as large.
constexpr ModeFigures MakeMemoryFigures() {
  ModeFigures figures = kHardFigures;
  figures.side = 40;
  figures.division_count = 16;
  figures.enemy_count_choices = 17;
  return figures;
}

constexpr ModeFigures kMemoryFigures = MakeMemoryFigures();

const ModeFigures& FiguresOf(DistributionMode mode) {
  switch (mode) {
    case DistributionMode::kEasy:
      return kEasyFigures;
    case DistributionMode::kExtreme:
      return kExtremeFigures;
    case DistributionMode::kMemory:
      return kMemoryFigures;
    default:
      return kHardFigures;
  }
}

// The box with its axes swapped.
Box Transposed(const Box& box) { return {box.y, box.x, box.height, box.width}; }

bool IsBall(int kind) { return kind == kBallKind || kind == kEnemyBallKind; }

class Dodgeball final : public Game {
 public:
  explicit Dodgeball(const GameOptions& options)
      : Game(kArt, options), figures_(FiguresOf(options.distribution_mode)) {
    top_speed_ = figures_.agent_speed;
    world_.out_of_bounds_kind = kHallOutsideKind;
  }

 private:
  // --- Level generation: walls of lava, the door at the edge of the hall, the agent, the enemies.

  void MakeLevel() override {
    StandardReset(figures_.side, figures_.side);
    center_agent_ = options().distribution_mode == DistributionMode::kMemory;
    throw_step_ = 0;
    world_.agent().rx = figures_.agent_radius;
    world_.agent().ry = figures_.agent_radius;
    DivideHall();
    PlaceDoor();
    PlaceAgentAtRandom(world_, random_);
    PlaceEnemies();
  }

  // Divides the hall into rooms. Repeatedly places a wall in the middle of a drawn room, over part
  // of its length. The rooms at its sides and the one beside its end can be divided in turn if they
  // are large enough.
  void DivideHall() {
    const auto side = static_cast<float>(figures_.side);
    std::vector<Box> rooms = {{.x = 0, .y = 0, .width = side, .height = side}};
    for (int i = 0; i < figures_.division_count && !rooms.empty(); ++i) {
      const int32_t index = random_.Int(static_cast<int32_t>(rooms.size()));
      const Box room = rooms[static_cast<size_t>(index)];
      rooms.erase(rooms.begin() + index);
      DivideRoom(room, &rooms);
    }
  }

  void DivideRoom(const Box& room, std::vector<Box>* rooms) {
    bool wall_is_level = random_.Unit() < 0.5F;
    const bool wall_is_low = random_.Unit() < 0.5F;
    const float gap_share = 0.25F * static_cast<float>(random_.Int(3) + 1);
    if (room.width < RoomLengthMin()) {
      wall_is_level = false;
    }
    if (room.height < RoomLengthMin()) {
      wall_is_level = true;
    }
    // Computed for a vertical wall; for a horizontal one the axes are swapped, and swapped back at
    // the end.
    const Box r = wall_is_level ? Transposed(room) : room;
    const float wall_share = 1 - gap_share;
    const float length = wall_share * r.height;
    const float wall_y = wall_is_low ? r.y : r.y + (1 - wall_share) * r.height;
    const float rest_y = wall_is_low ? r.y + wall_share * r.height : r.y;
    const float middle_x = r.x + r.width / 2;
    const float middle_y = wall_y + length / 2;
    const float lava_radius = figures_.lava_radius;
    if (wall_is_level) {
      AddLava(middle_y, middle_x, length / 2, lava_radius);
    } else {
      AddLava(middle_x, middle_y, lava_radius, length / 2);
    }
    const float beside_width = r.width / 2 - lava_radius;
    const std::array<Box, 3> parts = {{{r.x, wall_y, beside_width, length},
                                       {middle_x + lava_radius, wall_y, beside_width, length},
                                       {r.x, rest_y, r.width, r.height - length}}};
    for (const Box& part : parts) {
      if (CanBeDivided(part)) {
        rooms->push_back(wall_is_level ? Transposed(part) : part);
      }
    }
  }

  void AddLava(float x, float y, float rx, float ry) {
    Entity& lava = world_.entities.emplace_back(Entity::Make(kLavaKind, x, y, 0, 0, rx, ry));
    lava.meets_entities = true;
  }

  // A room can be divided if it is long enough, and wide enough to pass the wall on either side.
  bool CanBeDivided(const Box& room) const {
    const bool is_long = room.width >= RoomLengthMin() || room.height >= RoomLengthMin();
    return is_long && room.width >= RoomWidthMin() && room.height >= RoomWidthMin();
  }

  float RoomLengthMin() const { return static_cast<float>(figures_.agent_radius * 8 + 0.5); }

  float RoomWidthMin() const {
    const float passages = 4 * figures_.agent_radius + 2 * figures_.lava_radius;
    return static_cast<float>(passages + 0.5);
  }

  void PlaceDoor() {
    const auto side = static_cast<float>(figures_.side);
    const float radius = figures_.door_radius;
    const float depth = 2 * radius;
    const std::array<Box, 4> edges = {{{0, 0, side, depth},
                                       {0, side - depth, side, depth},
                                       {0, 0, depth, side},
                                       {side - depth, 0, depth, side}}};
    const auto edge = static_cast<size_t>(random_.Int(4));
    SpawnInBox(world_, random_, kDoorKind, radius, radius, edges[edge]);
  }

  void PlaceEnemies() {
    const auto side = static_cast<float>(figures_.side);
    const Box hall = {.x = 0, .y = 0, .width = side, .height = side};
    const float radius = figures_.enemy_radius;
    enemy_count_ = kEnemyCountMin + random_.Int(figures_.enemy_count_choices);
    for (int i = 0; i < enemy_count_; ++i) {
      SpawnInBox(world_, random_, kEnemyKind, radius, radius, hall);
    }
    const int theme = random_.Int(kEnemyThemesUsed);
    for (Entity& entity : world_.entities) {
      if (entity.kind == kEnemyKind) {
        entity.theme = theme;
        entity.shot_step = kEnemyFirstShotStep;
        entity.meets_entities = true;
        entity.smart = true;
        ChooseWay(entity);
        TurnTo(entity, entity.vx, entity.vy, 0);
      }
    }
  }

  // An enemy's spawn_step counts the steps until its next choice.
  void ChooseWay(Entity& enemy) {
    const float speed = enemy_speed_ * static_cast<float>(2 * random_.Int(2) - 1);
    const bool goes_sideways = random_.Int(2) == 0;
    enemy.vx = goes_sideways ? speed : 0;
    enemy.vy = goes_sideways ? 0 : speed;
    enemy.spawn_step = kEnemyWalkStepsMin + random_.Int(kEnemyWalkStepsRange);
  }

  // --- Step.

  void PlayStep() override {
    StandardStep();
    // Moves are numbered column by column, with "none" in the middle.
    const int32_t column = last_move_ / 3;
    const int32_t row = last_move_ % 3;
    const auto facing_x = static_cast<float>(column - 1);
    const auto facing_y = static_cast<float>(row - 1);
    TurnTo(world_.agent(), facing_x, facing_y, 0);
    if (special_action_ == kThrowAction && step_number() - throw_step_ >= kThrowPause) {
      AddBall(kBallKind, 0, facing_x, facing_y).meets_entities = true;
      throw_step_ = step_number();
    }
    enemy_count_ = 0;
    for (size_t i = world_.entities.size(); i-- > 0;) {
      Entity& entity = world_.entities[i];
      if (entity.kind == kEnemyKind) {
        ++enemy_count_;
        PlayEnemy(i);
      } else if (IsBall(entity.kind) && TouchesEdge(entity)) {
        entity.marked = true;
      }
    }
    RemoveGone(world_);
  }

  Entity& AddBall(int kind, size_t thrower, float direction_x, float direction_y) {
    Entity& ball = SpawnChild(world_, kind, figures_.ball_radius, world_.entities[thrower], false);
    ball.vx = direction_x * figures_.ball_speed;
    ball.vy = direction_y * figures_.ball_speed;
    ball.spin = kBallSpin;
    ball.expiry = kBallLife;
    return ball;
  }

  bool TouchesEdge(const Entity& ball) const {
    const auto side = static_cast<float>(figures_.side);
    return ball.x < ball.rx || ball.x > side - ball.rx || ball.y < ball.ry ||
           ball.y > side - ball.ry;
  }

  void PlayEnemy(size_t index) {
    Entity& enemy = world_.entities[index];
    if (enemy.spawn_step == 0) {
      ChooseWay(enemy);
    } else {
      --enemy.spawn_step;
    }
    if (step_number() - enemy.shot_step >= kEnemyThrowPause) {
      ThrowAtAgent(index);
    }
    // A new ball may have moved the entities in memory.
    Entity& walker = world_.entities[index];
    TurnTo(walker, walker.vx, walker.vy, 0);
  }

  // An enemy throws when the agent is almost straight above, below or beside it, and follows its
  // ball.
  void ThrowAtAgent(size_t thrower) {
    const Entity& agent = world_.agent();
    const float dx = world_.entities[thrower].x - agent.x;
    const float dy = world_.entities[thrower].y - agent.y;
    const bool in_column = std::fabs(dx) < kAimTolerance;
    if (!in_column && std::fabs(dy) >= kAimTolerance) {
      return;
    }
    const float direction_x = in_column ? 0.0F : (dx < 0 ? 1.0F : -1.0F);
    const float direction_y = !in_column ? 0.0F : (dy < 0 ? 1.0F : -1.0F);
    AddBall(kEnemyBallKind, thrower, direction_x, direction_y);
    Entity& enemy = world_.entities[thrower];
    enemy.shot_step = step_number() + random_.Int(kEnemyThrowPauseRange);
    enemy.vx = direction_x * enemy_speed_;
    enemy.vy = direction_y * enemy_speed_;
  }

  // --- Contacts.

  bool Reflects(const Entity& mover, int kind) override {
    return mover.kind == kEnemyKind && (kind == kHallOutsideKind || kind == kLavaKind);
  }

  void OnAgentContact(Entity& other) override {
    if (other.kind == kEnemyKind || other.kind == kEnemyBallKind || other.kind == kLavaKind) {
      outcome_.done = true;
    } else if (other.kind == kDoorKind && enemy_count_ == 0) {
      outcome_.reward += kDoorReward;
      outcome_.level_complete = true;
      outcome_.done = true;
    }
  }

  void OnEntityContact(Entity& self, Entity& other) override {
    if (self.kind == kLavaKind && IsBall(other.kind)) {
      other.marked = true;
    } else if (self.kind == kEnemyKind && other.kind == kBallKind) {
      other.marked = true;
      self.health -= 1;
      if (self.health <= 0) {
        self.marked = true;
        outcome_.reward += kHitReward;
        RaiseCloud(self);
      }
    }
  }

  void RaiseCloud(const Entity& enemy) {
    Entity& cloud = SpawnChild(world_, kCloudKind, enemy.rx, enemy, false);
    cloud.theme = world_.shared_random % ThemeCount(kCloudKind);
    cloud.spin = kCloudSpin;
    cloud.growth = kCloudGrowth;
    cloud.fading = kCloudFading;
    cloud.expiry = kCloudLife;
  }

  // --- Appearance.

  int ImageKindOf(const Entity& entity) const override {
    return entity.kind == kDoorKind && enemy_count_ == 0 ? kOpenDoorImageKind
                                                         : Game::ImageKindOf(entity);
  }

  void StyleSprite(const Entity& entity, Sprite* sprite) const override {
    if (entity.kind == kLavaKind) {
      sprite->tile_ratio = entity.rx > entity.ry ? 1 : -1;
    }
  }

  void VisitOwnState(StateArchive& archive) override {
    archive.Int("enemy_count", enemy_count_, 0, static_cast<int32_t>(kEntityCountMax));
    archive.Int("throw_step", throw_step_, 0, kRememberedStepMax);
  }

  const ModeFigures& figures_;
  int32_t enemy_count_ = 0;  // counted in the last step
  int32_t throw_step_ = 0;   // step of the agent's last throw
  const float enemy_speed_ = ValueOf(Variant::kEnemySpeed, kEnemySpeed);
};

}  // namespace

extern constexpr GameSpec kDodgeball = {
    .name = "dodgeball",
    .description = "The agent throws balls at enemies, dodges theirs and leaves by the door.",
    .modes = kAllModes,
    .easy_returns = {1.5, 19},
    .hard_returns = {1.5, 19},
    .special_actions = kSpecialActions,
    .kinds = kKinds,
    .make = MakeGame<Dodgeball>,
};

}  // namespace procgen
