// StarPilot: a ship flies freely in a field that enemies cross in groups, mostly from the right.
// The level determines which enemies come and when. Each destroyed enemy pays +1. Touching an
// enemy, a meteor or a bullet ends the episode. After 500 steps a rocket as high as the field
// appears; touching it completes the level (+10).

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "envcore/games/game.h"
#include "envcore/games/game_spec.h"
#include "envcore/world/direction.h"
#include "envcore/world/placing.h"

namespace procgen {
namespace {

constexpr int kPlayerBulletKind = 1;
constexpr int kFlyerBulletKind = 2;
constexpr int kTurretBulletKind = 3;
constexpr int kFlyerKind = 4;
constexpr int kMeteorKind = 5;
constexpr int kCloudKind = 6;  // harmless, covers what is below it
constexpr int kTurretKind = 7;
constexpr int kFastFlyerKind = 8;
constexpr int kRocketKind = 9;

constexpr KindName kKinds[] = {{kPlayerBulletKind, "player_bullet"},
                               {kFlyerBulletKind, "flyer_bullet"},
                               {kTurretBulletKind, "turret_bullet"},
                               {kFlyerKind, "flyer"},
                               {kMeteorKind, "meteor"},
                               {kCloudKind, "cloud"},
                               {kTurretKind, "turret"},
                               {kFastFlyerKind, "fast_flyer"},
                               {kRocketKind, "rocket"}};

constexpr SpecialAction kSpecialActions[] = {
    {9, "Fires a bullet forwards."},  {10, "Fires a bullet backwards."},
    {11, "Fires a bullet forwards."}, {12, "Fires a bullet forwards."},
    {13, "Fires a bullet forwards."}, {14, "Fires a bullet forwards."}};

constexpr int kWorldSide = 16;        // cells
constexpr float kSpeedUnit = 0.4F;    // cells per step
constexpr float kFlyerRadius = 0.5F;  // cells
constexpr float kLargeRadius = 2;     // of meteors, clouds and turrets
constexpr float kRocketRadius = 8;    // half-height; the width follows the art
constexpr float kFastFlyerSpeed = 1.5F * kSpeedUnit;
constexpr float kDriftSpeed = 0.5F * kSpeedUnit;    // of meteors, clouds, turrets and the rocket
constexpr float kFastBulletSpeed = 2 * kSpeedUnit;  // of turrets and player
constexpr float kMeteorHealth = 500;                // more than the player can shoot down

constexpr int kRocketStep = 500;
constexpr int kGroupPauseMin = 10;  // steps between groups
constexpr int kGroupPauseEnd = 30;
constexpr int kGroupSizeMax = 5;
constexpr int kGroupSpacing = 5;    // steps between members
constexpr int kShipThemeCount = 7;  // a rule: drawn with any art
constexpr int kShotStepMin = 10;    // steps after its spawn at which a flyer fires
constexpr int kShotStepEnd = 100;
constexpr int kTurretPeriodMin = 20;  // steps
constexpr int kTurretPeriodEnd = 30;
constexpr float kCourseRange = (2 * kPi) / 4;  // radians; half of it up, half down
constexpr float kFromRightShare = 0.9F;

constexpr int kBackwardShot = 2;         // special action; all others shoot forward
constexpr float kExplosionShare = 0.5F;  // of the half-width of the exploding entity
constexpr float kEnemyReward = 1;
constexpr float kRocketReward = 10;

// Relative frequencies of the kinds of groups, starting at kFlyerBulletKind. A lone bullet comes
// only with a draw of exactly 0.
constexpr std::array<float, 7> kWeightsEasy = {0, 0, 3, 0, 0, 0, 0};
constexpr std::array<float, 7> kWeights = {0, 0, 3, 1, 1, 1, 1};

// The differences between the distribution modes.
struct Figures {
  float top_speed;  // of the agent, cells per step
  float bullet_radius;
  float flyer_speed;
  float flyer_bullet_speed;
  float flyer_health;
  float fast_flyer_health;
  float turret_health;
};

constexpr Figures kEasyFigures = {.top_speed = 0.75F,
                                  .bullet_radius = 0.4F,
                                  .flyer_speed = 0.75F * kSpeedUnit,
                                  .flyer_bullet_speed = 1.25F * kSpeedUnit,
                                  .flyer_health = 2,
                                  .fast_flyer_health = 0,
                                  .turret_health = 0};
constexpr Figures kHardFigures = {.top_speed = 0.75F,
                                  .bullet_radius = 0.4F,
                                  .flyer_speed = kSpeedUnit,
                                  .flyer_bullet_speed = kFastBulletSpeed,
                                  .flyer_health = 2,
                                  .fast_flyer_health = 1,
                                  .turret_health = 5};
constexpr Figures kExtremeFigures = {.top_speed = 0.5F,
                                     .bullet_radius = 0.2F,
                                     .flyer_speed = kSpeedUnit,
                                     .flyer_bullet_speed = kFastBulletSpeed,
                                     .flyer_health = 5,
                                     .fast_flyer_health = 2,
                                     .turret_health = 10};

constexpr ArtSlot kArtSlots[] = {
    {0, 0, "agent", "misc_assets/playerShip2_blue.png", 112, 75},
    {1, 0, "player_bullet", "misc_assets/towerDefense_tile295.png", 60, 60},
    {2, 0, "flyer_bullet", "misc_assets/towerDefense_tile296.png", 68, 68},
    {3, 0, "turret_bullet", "misc_assets/towerDefense_tile297.png", 76, 76},
    {4, 0, "flyer", "misc_assets/spaceShips_001.png", 106, 80},
    {4, 1, "flyer", "misc_assets/spaceShips_002.png", 101, 74},
    {4, 2, "flyer", "misc_assets/spaceShips_003.png", 100, 94},
    {4, 3, "flyer", "misc_assets/spaceShips_004.png", 126, 108},
    {4, 4, "flyer", "misc_assets/spaceShips_005.png", 136, 84},
    {4, 5, "flyer", "misc_assets/spaceShips_006.png", 94, 148},
    {4, 6, "flyer", "misc_assets/spaceShips_007.png", 172, 151},
    {5, 0, "meteor", "misc_assets/spaceMeteors_001.png", 215, 211},
    {5, 1, "meteor", "misc_assets/spaceMeteors_002.png", 212, 218},
    {5, 2, "meteor", "misc_assets/spaceMeteors_003.png", 214, 227},
    {5, 3, "meteor", "misc_assets/spaceMeteors_004.png", 220, 221},
    {5, 4, "meteor", "misc_assets/meteorGrey_big1.png", 101, 84},
    {5, 5, "meteor", "misc_assets/meteorGrey_big2.png", 120, 98},
    {5, 6, "meteor", "misc_assets/meteorGrey_big3.png", 89, 82},
    {5, 7, "meteor", "misc_assets/meteorGrey_big4.png", 98, 96},
    {6, 0, "cloud", "misc_assets/spaceEffect1.png", 41, 42},
    {6, 1, "cloud", "misc_assets/spaceEffect2.png", 56, 49},
    {6, 2, "cloud", "misc_assets/spaceEffect3.png", 59, 55},
    {6, 3, "cloud", "misc_assets/spaceEffect4.png", 52, 50},
    {6, 4, "cloud", "misc_assets/spaceEffect5.png", 63, 65},
    {6, 5, "cloud", "misc_assets/spaceEffect6.png", 73, 72},
    {6, 6, "cloud", "misc_assets/spaceEffect7.png", 87, 100},
    {6, 7, "cloud", "misc_assets/spaceEffect8.png", 100, 102},
    {6, 8, "cloud", "misc_assets/spaceEffect9.png", 69, 71},
    {7, 0, "turret", "misc_assets/spaceStation_018.png", 172, 52},
    {7, 1, "turret", "misc_assets/spaceStation_019.png", 172, 52},
    {8, 0, "fast_flyer", "misc_assets/spaceShips_001.png", 106, 80},
    {8, 1, "fast_flyer", "misc_assets/spaceShips_002.png", 101, 74},
    {8, 2, "fast_flyer", "misc_assets/spaceShips_003.png", 100, 94},
    {8, 3, "fast_flyer", "misc_assets/spaceShips_004.png", 126, 108},
    {8, 4, "fast_flyer", "misc_assets/spaceShips_005.png", 136, 84},
    {8, 5, "fast_flyer", "misc_assets/spaceShips_006.png", 94, 148},
    {8, 6, "fast_flyer", "misc_assets/spaceShips_007.png", 172, 151},
    {9, 0, "rocket", "misc_assets/spaceRockets_001.png", 122, 374},
    {9, 1, "rocket", "misc_assets/spaceRockets_002.png", 157, 309},
    {9, 2, "rocket", "misc_assets/spaceRockets_003.png", 118, 315},
    {9, 3, "rocket", "misc_assets/spaceRockets_004.png", 136, 369},
};

constexpr GameArtSpec kArt = {
    .slots = kArtSlots, .background_group = BackgroundGroup::kSpace, .background_scrolls = true};

const Figures& FiguresOf(DistributionMode mode) {
  switch (mode) {
    case DistributionMode::kEasy:
      return kEasyFigures;
    case DistributionMode::kExtreme:
      return kExtremeFigures;
    default:
      return kHardFigures;
  }
}

bool IsFlyer(int kind) { return kind == kFlyerKind || kind == kFastFlyerKind; }

bool IsLarge(int kind) { return kind == kMeteorKind || kind == kCloudKind || kind == kTurretKind; }

bool IsDestructible(int kind) {
  return IsFlyer(kind) || kind == kMeteorKind || kind == kTurretKind;
}

bool IsLethal(int kind) {
  return IsDestructible(kind) || kind == kFlyerBulletKind || kind == kTurretBulletKind;
}

class StarPilot final : public Game {
 public:
  explicit StarPilot(const GameOptions& options)
      : Game(kArt, options),
        is_easy_(options.distribution_mode == DistributionMode::kEasy),
        figures_(FiguresOf(options.distribution_mode)) {
    top_speed_ = figures_.top_speed;
  }

 private:
  // --- Level generation: the field is empty; everything that will come is planned now.

  void MakeLevel() override {
    StandardReset(kWorldSide, kWorldSide);
    center_agent_ = false;
    PlanSpawns();
    Entity& agent = world_.agent();
    agent.rotation = kHalfPi;
    agent.theme = DrawTheme(kAgentKind);
  }

  void PlanSpawns() {
    spawns_.clear();
    int32_t step = 1 + random_.Int(kGroupPauseMin, kGroupPauseEnd);
    while (step <= kRocketStep) {
      PlanGroup(step);
      step += random_.Int(kGroupPauseMin, kGroupPauseEnd);
    }
    // The order in which std::sort of libstdc++ leaves equal steps is a rule. A stable sort gives
    // another order.
    std::sort(spawns_.begin(), spawns_.end(),
              [](const Entity& a, const Entity& b) { return a.spawn_step > b.spawn_step; });
  }

  void PlanGroup(int32_t first_step) {
    const int kind = DrawKind();
    int32_t size = 1;
    int32_t ship_theme = 0;
    if (IsFlyer(kind)) {
      size = random_.Int(0, kGroupSizeMax) + 1;
      ship_theme = random_.Int(kShipThemeCount);
    }
    const float radius = IsLarge(kind) ? kLargeRadius : kFlyerRadius;
    const float y = (kWorldSide - 2 * radius) * random_.Unit() + radius;
    for (int32_t i = 0; i < size; ++i) {
      Entity spawn = Entity::Make(kind, 0, y, 0, 0, radius, radius);
      spawn.spawn_step = first_step + kGroupSpacing * i;
      spawn.theme = ship_theme;
      spawn.health = HealthOf(kind);
      PlanMember(spawn);
      spawns_.push_back(spawn);
    }
  }

  int DrawKind() {
    const std::array<float, 7>& weights = is_easy_ ? kWeightsEasy : kWeights;
    float total = 0;
    for (const float weight : weights) {
      total += weight;
    }
    const float drawn = random_.Unit() * total;
    size_t index = 0;
    float passed = weights[0];
    while (drawn > passed) {
      ++index;
      passed += weights[index];
    }
    return kFlyerBulletKind + static_cast<int>(index);
  }

  float HealthOf(int kind) const {
    switch (kind) {
      case kFlyerKind:
        return figures_.flyer_health;
      case kFastFlyerKind:
        return figures_.fast_flyer_health;
      case kTurretKind:
        return figures_.turret_health;
      case kMeteorKind:
        return kMeteorHealth;
      default:
        return 0;
    }
  }

  float SpeedOf(int kind) const {
    switch (kind) {
      case kFlyerKind:
        return figures_.flyer_speed;
      case kFastFlyerKind:
        return kFastFlyerSpeed;
      case kFlyerBulletKind:
        return figures_.flyer_bullet_speed;
      default:
        return kDriftSpeed;
    }
  }

  // Draws when a spawn fires, its direction, its side and its image. Some draws are not used.
  void PlanMember(Entity& spawn) {
    spawn.shot_step = random_.Int(kShotStepMin, kShotStepEnd);
    const double course_share = random_.Unit();
    auto course = static_cast<float>((course_share - 0.5) * kCourseRange);
    const bool straight = random_.Int(0, 2) == 1;
    if (straight || IsLarge(spawn.kind)) {
      course = 0;
    }
    if (spawn.kind == kMeteorKind || spawn.kind == kCloudKind) {
      spawn.shot_step = -1;
    } else if (spawn.kind == kTurretKind) {
      spawn.shot_step = random_.Int(kTurretPeriodMin, kTurretPeriodEnd);
    }
    const double speed = SpeedOf(spawn.kind);
    spawn.vx = static_cast<float>(-std::cos(static_cast<double>(course)) * speed);
    spawn.vy = static_cast<float>(std::sin(static_cast<double>(course)) * speed);
    spawn.x = kWorldSide + spawn.rx;
    if (IsFlyer(spawn.kind)) {
      const float side = random_.Unit();
      if (side > kFromRightShare && !is_easy_) {
        spawn.x = -spawn.rx;
        spawn.vx = -spawn.vx;
      }
      spawn.rotation = spawn.vx > 0 ? -kHalfPi : kHalfPi;
    } else if (IsLarge(spawn.kind)) {
      spawn.theme = DrawTheme(spawn.kind);
    }
    if (spawn.kind == kCloudKind) {
      spawn.layer = 1;
    } else if (spawn.kind == kTurretKind) {
      spawn.ry = kLargeRadius / AspectRatio(kTurretKind, spawn.theme);
    }
  }

  // --- Step.

  void PlayStep() override {
    StandardStep();
    for (size_t i = world_.entities.size(); i-- > 1;) {
      if (IsTimeToFire(world_.entities[i])) {
        FireAtAgent(i);
      }
      Entity& entity = world_.entities[i];
      if (entity.health <= 0 && IsDestructible(entity.kind) && !entity.marked) {
        outcome_.reward += kEnemyReward;
        entity.marked = true;
        SpawnChild(world_, kExplosionKind, kExplosionShare * entity.rx, entity, true);
      }
    }
    while (!spawns_.empty() && spawns_.back().spawn_step == step_number()) {
      world_.entities.push_back(spawns_.back());
      spawns_.pop_back();
    }
    if (special_action_ != 0) {
      Shoot(special_action_ == kBackwardShot ? kPi : 0);
    }
    if (step_number() == kRocketStep) {
      LaunchRocket();
    }
  }

  // A turret fires repeatedly, everything else once.
  bool IsTimeToFire(const Entity& entity) const {
    if (entity.shot_step <= 0) {
      return false;
    }
    const int32_t age = step_number() - entity.spawn_step;
    return entity.kind == kTurretKind ? age % entity.shot_step == 0 : age == entity.shot_step;
  }

  void FireAtAgent(size_t shooter_index) {
    const Entity& shooter = world_.entities[shooter_index];
    const bool from_turret = shooter.kind == kTurretKind;
    const float speed = from_turret ? kFastBulletSpeed : figures_.flyer_bullet_speed;
    const float dx = world_.agent().x - shooter.x;
    const float dy = world_.agent().y - shooter.y;
    const float distance_squared = dx * dx + dy * dy;
    // At the agent's exact position there is no direction; the episode has ended then.
    const auto scale = distance_squared == 0
                           ? 0.0F
                           : static_cast<float>(static_cast<double>(speed) /
                                                std::sqrt(static_cast<double>(distance_squared)));
    Entity& bullet = SpawnChild(world_, from_turret ? kTurretBulletKind : kFlyerBulletKind,
                                figures_.bullet_radius, shooter, false);
    bullet.vx = dx * scale;
    bullet.vy = dy * scale;
    TurnTo(bullet, bullet.vx, bullet.vy, -kHalfPi);
  }

  void Shoot(float angle) {
    const double cosine = std::cos(static_cast<double>(angle));
    const double sine = std::sin(static_cast<double>(angle));
    const float x = world_.agent().x + static_cast<float>(world_.agent().rx * cosine);
    const auto vx = static_cast<float>(cosine * kFastBulletSpeed);
    const auto vy = static_cast<float>(sine * kFastBulletSpeed);
    Entity& bullet =
        world_.entities.emplace_back(Entity::Make(kPlayerBulletKind, x, world_.agent().y, vx, vy,
                                                  figures_.bullet_radius, figures_.bullet_radius));
    bullet.meets_entities = true;
    TurnTo(bullet, vx, vy, -kHalfPi);
  }

  void LaunchRocket() {
    Entity rocket = Entity::Make(kRocketKind, 0, kRocketRadius, -kDriftSpeed, 0, 0, kRocketRadius);
    rocket.theme = DrawTheme(kRocketKind);
    rocket.rx = kRocketRadius * AspectRatio(kRocketKind, rocket.theme);
    rocket.x = kWorldSide + rocket.rx;
    world_.entities.push_back(rocket);
  }

  // --- Contacts.

  void OnAgentContact(Entity& other) override {
    if (other.kind == kRocketKind) {
      outcome_.reward += kRocketReward;
      outcome_.level_complete = true;
      outcome_.done = true;
    } else if (IsLethal(other.kind)) {
      outcome_.done = true;
    }
  }

  // Only the player's bullets test for contacts. What they destroy is removed at the end of the
  // step.
  void OnEntityContact(Entity& self, Entity& other) override {
    if (!IsDestructible(other.kind)) {
      return;
    }
    self.marked = true;
    other.health -= 1;
    const float vx = other.vx;
    const float vy = other.vy;
    Entity& explosion = SpawnChild(world_, kExplosionKind, kExplosionShare * self.rx, self, false);
    explosion.vx = vx;
    explosion.vy = vy;
  }

  void VisitOwnState(StateArchive& archive) override {
    // All spawns are planned with the level, so the number left determines them.
    auto spawns_left = static_cast<int32_t>(spawns_.size());
    archive.Int("spawns_left", spawns_left, 0, spawns_left);
    spawns_.resize(static_cast<size_t>(spawns_left));
  }

  bool is_easy_;
  const Figures& figures_;
  std::vector<Entity> spawns_;  // still to come, the next one last
};

}  // namespace

extern constexpr GameSpec kStarPilot = {
    .name = "starpilot",
    .description = "A ship flies sideways through waves of enemies and shoots them.",
    .modes = kWithExtreme,
    .easy_returns = {2.5, 64},
    .hard_returns = {1.5, 35},
    .special_actions = kSpecialActions,
    .kinds = kKinds,
    .make = MakeGame<StarPilot>,
};

}  // namespace procgen
