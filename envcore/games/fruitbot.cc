// FruitBot: a robot drives up a long narrow field, seen from above. The player steers it left and
// right and throws keys. It must pass the gaps of walls, collect fruit (+1) and avoid other food
// (-4). Touching a wall or a locked door ends the episode. A key that hits the lock of a door opens
// the door. The presents at the upper end complete the level (+10 for each one touched).

#include <algorithm>
#include <cmath>
#include <vector>

#include "envcore/games/game.h"
#include "envcore/games/game_spec.h"
#include "envcore/world/direction.h"
#include "envcore/world/placing.h"
#include "envcore/world/world_state.h"

namespace procgen {
namespace {

constexpr int kFruitBotWallKind = 1;
constexpr int kStoneKind = 2;  // outside the world
constexpr int kKeyKind = 3;
constexpr int kFoodKind = 4;
constexpr int kFruitKind = 7;
constexpr int kDoorKind = 10;
constexpr int kLockKind = 11;
constexpr int kPresentKind = 12;

constexpr KindName kKinds[] = {{kFruitBotWallKind, "barrier"},
                               {kStoneKind, "stone"},
                               {kKeyKind, "key"},
                               {kFoodKind, "food"},
                               {kFruitKind, "fruit"},
                               {kDoorKind, "door"},
                               {kLockKind, "lock"},
                               {kPresentKind, "present", true}};

constexpr SpecialAction kSpecialActions[] = {
    {9, "Throws a key upwards that opens doors, at most once in 8 steps."}};

constexpr int kWorldHeight = 60;  // cells
constexpr float kItemRadius =
    0.5F;  // of fruit, food (before scaling to the art's shape) and presents
constexpr int kFruitCountMin = 10;
constexpr int kFoodCountMin = 10;
constexpr int kItemCountRange = 10;  // number of different counts of fruit, and of food

constexpr float kTopSpeed = 0.85F;          // cells per step
constexpr float kUpwardPush = 0.2F;         // replaces the vertical part of the action
constexpr float kAgentRotation = -kHalfPi;  // the art faces right, the robot drives up
constexpr float kFruitReward = 1;
constexpr float kFoodReward = -4;
constexpr float kPresentReward = 10;

constexpr float kKeyRadius = 0.25F;  // cells
constexpr float kKeySpeed = 0.5F;    // cells per step, upward
constexpr int kKeyLifeSteps = 8;
constexpr int kKeyPauseSteps = 8;  // least steps from one key to the next
constexpr int kThrowAction = 1;    // special action

constexpr int kWallDistanceMin = 4;       // cells between walls
constexpr int kLockableWallDistance = 5;  // only walls farther from the one below may be locked
constexpr float kWallRadiusY = 0.3F;      // of walls and doors, cells
constexpr double kGapShareRange = 0.2;    // of the world's width
constexpr float kLockedGapShareExtra = 0.1F;
constexpr float kLockRadiusX = 0.25F;
constexpr float kLockRadiusY = 0.45F;
constexpr float kLockReach = 1;  // the vertical distance of a lock to its door is less than this
constexpr float kWallTileRatio = 1;  // width / height of a tile of the art
constexpr float kDoorTileRatio = 3.25F;
constexpr int kViewMargin = 2;  // half-heights from the lower edge of the view to the agent

struct ModeFigures {
  int world_width;  // cells
  int wall_count;
  float gap_share_min;   // of the world's width
  float lock_chance;     // per wall that may be locked
  int item_theme_count;  // number of different images of fruit, and of food
};

constexpr ModeFigures kEasyFigures = {.world_width = 10,
                                      .wall_count = 5,
                                      .gap_share_min = 0.2F,
                                      .lock_chance = 0,
                                      .item_theme_count = 2};
constexpr ModeFigures kHardFigures = {.world_width = 20,
                                      .wall_count = 10,
                                      .gap_share_min = 0.1F,
                                      .lock_chance = 0.125F,
                                      .item_theme_count = 6};

constexpr ArtSlot kArtSlots[] = {
    {0, 0, "robot", "misc_assets/robot_3Dblue.png", 148, 154},
    {1, 0, "wall", "misc_assets/tileStone_slope.png", 16, 16},
    {2, 0, "stone", "misc_assets/tileStone_slope.png", 16, 16},
    {3, 0, "key", "misc_assets/keyRed2.png", 32, 32},
    {4, 0, "food", "misc_assets/food1.png", 14, 25},
    {4, 1, "food", "misc_assets/food2.png", 28, 13},
    {4, 2, "food", "misc_assets/food3.png", 19, 19},
    {4, 3, "food", "misc_assets/food4.png", 21, 20},
    {4, 4, "food", "misc_assets/food5.png", 22, 24},
    {4, 5, "food", "misc_assets/food6.png", 22, 22},
    {7, 0, "fruit", "misc_assets/fruit1.png", 27, 28},
    {7, 1, "fruit", "misc_assets/fruit2.png", 24, 30},
    {7, 2, "fruit", "misc_assets/fruit3.png", 30, 22},
    {7, 3, "fruit", "misc_assets/fruit4.png", 20, 31},
    {7, 4, "fruit", "misc_assets/fruit5.png", 23, 23},
    {7, 5, "fruit", "misc_assets/fruit6.png", 22, 26},
    {10, 0, "door", "misc_assets/fenceYellow.png", 104, 32},
    {11, 0, "lock", "misc_assets/lockRed2.png", 70, 105},
    {12, 0, "present", "misc_assets/present1.png", 26, 26},
    {12, 1, "present", "misc_assets/present2.png", 26, 26},
    {12, 2, "present", "misc_assets/present3.png", 26, 26},
};

constexpr int kBlockShapedKinds[] = {kFruitBotWallKind, kDoorKind, kPresentKind};

constexpr GameArtSpec kArt = {.slots = kArtSlots,
                              .block_shaped_kinds = kBlockShapedKinds,
                              .background_group = BackgroundGroup::kTopdown,
                              .background_tile_ratio = -1};

class FruitBot final : public Game {
 public:
  explicit FruitBot(const GameOptions& options)
      : Game(kArt, options),
        figures_(options.distribution_mode == DistributionMode::kEasy ? kEasyFigures
                                                                      : kHardFigures) {
    cells_in_view_ = static_cast<float>(figures_.world_width);
    top_speed_ = kTopSpeed;
    world_.out_of_bounds_kind = kStoneKind;
  }

 private:
  // --- Level generation: walls from the bottom, presents at the upper end, fruit and food between
  // them.

  void MakeLevel() override {
    StandardReset(figures_.world_width, kWorldHeight);
    last_key_step_ = 0;
    MakeWalls();
    world_.agent().y = world_.agent().ry;
    const int fruit_count = random_.Int(kItemCountRange) + kFruitCountMin;
    const int food_count = random_.Int(kItemCountRange) + kFoodCountMin;
    for (int x = 0; x < figures_.world_width; ++x) {
      Entity& present =
          SpawnAtCell(world_, kPresentKind, kItemRadius, world_.grid.IndexOf(x, kWorldHeight - 1));
      present.theme = DrawTheme(kPresentKind);
    }
    SpawnItems(kFruitKind, fruit_count);
    SpawnItems(kFoodKind, food_count);
    for (Entity& entity : world_.entities) {
      if (entity.kind == kFruitKind || entity.kind == kFoodKind) {
        entity.theme = random_.Int(figures_.item_theme_count);
        TakeShapeOfArt(entity);
      }
    }
    world_.agent().rotation = kAgentRotation;
  }

  // Distributes the spare height of the field among the walls, beyond their minimum distances.
  void MakeWalls() {
    const int spare_height = kWorldHeight - kWallDistanceMin * (figures_.wall_count + 1);
    const std::vector<int32_t> spare_heights = random_.Split(spare_height, figures_.wall_count);
    int height = 0;
    for (const int32_t spare : spare_heights) {
      const int distance = kWallDistanceMin + spare;
      height += distance;
      bool is_locked = false;
      if (distance > kLockableWallDistance) {
        is_locked = random_.Unit() < figures_.lock_chance;
      }
      MakeWall(static_cast<float>(height), is_locked);
    }
  }

  // Makes a wall across the field at height `y`, with a gap that is closed by a door if
  // `is_locked`.
  void MakeWall(float y, bool is_locked) {
    const auto world_width = static_cast<float>(figures_.world_width);
    const double gap_share_extra = random_.Unit() * kGapShareRange;
    auto gap_share = static_cast<float>(gap_share_extra + figures_.gap_share_min);
    if (is_locked) {
      gap_share = LockedGapShare(gap_share + kLockedGapShareExtra);
    }
    const float gap_width = gap_share * world_width;
    const float left_width = random_.Unit() * (world_width - gap_width);
    const float right_width = (world_width - left_width) - gap_width;
    AddBox(kFruitBotWallKind, left_width / 2, y, left_width / 2, kWallRadiusY);
    AddBox(kFruitBotWallKind, world_width - right_width / 2, y, right_width / 2, kWallRadiusY);
    if (is_locked) {
      const auto side = static_cast<float>(random_.Int(2));  // 1: the lock is right of the door
      const float door_x = (left_width + gap_width / 2) - (2 * side - 1) * kLockRadiusX;
      const float lock_x = (left_width + kLockRadiusX) + side * (gap_width - 2 * kLockRadiusX);
      AddBox(kDoorKind, door_x, y, gap_width / 2 - kLockRadiusX, kWallRadiusY);
      AddBox(kLockKind, lock_x, (y - kLockRadiusY) + kWallRadiusY, kLockRadiusX, kLockRadiusY);
    }
  }

  // The fraction of the field's width that fits a lock and whole tiles of door; at least
  // `gap_share`.
  float LockedGapShare(float gap_share) const {
    const auto world_width = static_cast<float>(figures_.world_width);
    const float lock_share = (2 * kLockRadiusX) / world_width;
    const float tile_share = ((kWallRadiusY * 2) * kDoorTileRatio) / world_width;
    const float tile_count = std::ceil((gap_share - 2 * lock_share) / tile_share);
    return 2 * lock_share + tile_share * tile_count;
  }

  void AddBox(int kind, float x, float y, float rx, float ry) {
    world_.entities.push_back(Entity::Make(kind, x, y, 0, 0, rx, ry));
  }

  void SpawnItems(int kind, int count) {
    const Box field = {
        .x = 0, .y = 0, .width = static_cast<float>(figures_.world_width), .height = kWorldHeight};
    for (int i = 0; i < count; ++i) {
      SpawnInBox(world_, random_, kind, kItemRadius, kItemRadius, field);
    }
  }

  void TakeShapeOfArt(Entity& entity) const {
    const float ratio = AspectRatio(entity.kind, entity.theme);
    if (ratio > 1) {
      entity.ry = entity.rx / ratio;
    } else {
      entity.rx = entity.ry * ratio;
    }
  }

  // --- Step.

  void MapControls() override { world_.controls.vertical = kUpwardPush; }

  void PlayStep() override {
    StandardStep();
    if (special_action_ == kThrowAction && step_number() - last_key_step_ >= kKeyPauseSteps) {
      Entity& key = SpawnChild(world_, kKeyKind, kKeyRadius, world_.agent(), false);
      key.vy = kKeySpeed;
      key.expiry = kKeyLifeSteps;
      key.meets_entities = true;
      last_key_step_ = step_number();
    }
  }

  // --- Contacts.

  void OnAgentContact(Entity& other) override {
    switch (other.kind) {
      case kFruitBotWallKind:
      case kDoorKind:  // even if it was unlocked in this step
        outcome_.done = true;
        break;
      case kFruitKind:
        outcome_.reward += kFruitReward;
        other.marked = true;
        break;
      case kFoodKind:
        outcome_.reward += kFoodReward;
        other.marked = true;
        break;
      case kPresentKind:
        outcome_.reward += kPresentReward;
        outcome_.level_complete = true;
        outcome_.done = true;
        break;
      default:
        break;
    }
  }

  // Only keys test for contacts: walls stop them, locks open.
  void OnEntityContact(Entity& self, Entity& other) override {
    if (other.kind == kFruitBotWallKind) {
      self.marked = true;
    } else if (other.kind == kLockKind) {
      self.marked = true;
      other.marked = true;
      OpenDoorOf(other);
    }
  }

  void OpenDoorOf(const Entity& lock) {
    const auto door =
        std::find_if(world_.entities.begin(), world_.entities.end(), [&lock](const Entity& entity) {
          return entity.kind == kDoorKind && std::fabs(entity.y - lock.y) < kLockReach;
        });
    if (door != world_.entities.end()) {
      door->marked = true;
    }
  }

  // --- Appearance.

  // The view is as wide as the field and shows the part above the robot.
  Camera MakeCamera() const override {
    Camera camera = Game::MakeCamera();
    if (center_agent_) {
      const Entity& agent = world_.agent();
      camera.center_x = static_cast<float>(figures_.world_width / 2.0);
      camera.center_y = static_cast<float>((agent.y + figures_.world_width / 2.0) -
                                           static_cast<double>(kViewMargin * agent.ry));
    }
    return camera;
  }

  void StyleSprite(const Entity& entity, Sprite* sprite) const override {
    if (entity.kind == kFruitBotWallKind) {
      sprite->tile_ratio = kWallTileRatio;
    } else if (entity.kind == kDoorKind) {
      sprite->tile_ratio = kDoorTileRatio;
    }
  }

  void VisitOwnState(StateArchive& archive) override {
    archive.Int("last_key_step", last_key_step_, 0, kRememberedStepMax);
  }

  const ModeFigures& figures_;
  int32_t last_key_step_ = 0;
};

}  // namespace

extern constexpr GameSpec kFruitBot = {
    .name = "fruitbot",
    .description = "A robot collects fruit, avoids other food and passes gates and doors.",
    .modes = kEasyHard,
    .easy_returns = {-1.5, 32.4},
    .hard_returns = {-0.5, 27.2},
    .special_actions = kSpecialActions,
    .kinds = kKinds,
    .make = MakeGame<FruitBot>,
};

}  // namespace procgen
