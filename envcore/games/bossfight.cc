// BossFight: a ship at the bottom of the field fights a large boss ship above. While the boss's
// shield is up, the boss fires in patterns and the player's bullets bounce off. Then the shield is
// down until the boss has lost part of its health, which ends a round (+1). After the last round
// the boss is destroyed (+10, level complete). Touching the boss, one of its bullets or a barrier
// ends the episode.

#include <cmath>
#include <cstdlib>

#include "envcore/games/game.h"
#include "envcore/games/game_spec.h"
#include "envcore/world/direction.h"
#include "envcore/world/placing.h"
#include "envcore/world/world_state.h"

namespace procgen {
namespace {

constexpr int kPlayerBulletKind = 1;
constexpr int kBossKind = 2;
constexpr int kShieldKind = 3;
constexpr int kBossBulletKind = 4;
constexpr int kTrailPieceKind = 5;       // with the image of a boss bullet
constexpr int kReflectedBulletKind = 6;  // with the image of a player's bullet
constexpr int kBarrierKind = 7;          // a meteor that does not move

constexpr KindName kKinds[] = {{kPlayerBulletKind, "player_bullet"},
                               {kBossKind, "boss"},
                               {kShieldKind, "shield"},
                               {kBossBulletKind, "boss_bullet"},
                               {kTrailPieceKind, "bullet_trail"},
                               {kReflectedBulletKind, "reflected_bullet"},
                               {kBarrierKind, "meteor"}};

constexpr SpecialAction kSpecialActions[] = {
    {9, "Fires a bullet upwards, at most once in 3 steps."}};

constexpr size_t kBossIndex = 1;  // index in world_.entities; boss and shield are always there
constexpr size_t kShieldIndex = 2;

constexpr int kWorldSide = 20;         // cells
constexpr float kTopSpeed = 0.85F;     // cells per step
constexpr float kAgentRadius = 0.75F;  // half-widths, cells; the heights follow the art
constexpr float kBossRadius = 3;
constexpr float kBarrierRadius = 0.6F;
constexpr double kShieldShare = 1.2;  // of the boss's size

constexpr float kPlayerBulletRadius = 0.25F;
constexpr float kPlayerBulletSpeed = 1;
constexpr int kPlayerBulletExpiry = 25;  // steps
constexpr int kShotPause = 3;            // least steps from one shot to the next
constexpr double kReflectedSpeed = 0.5;
constexpr int kReflectedExpiry = 4;
constexpr float kReflectedFading = 0.8F;
constexpr int kLaserThemeCount = 3;  // a rule: drawn with any art

constexpr float kBossBulletRadius = 0.5F;
constexpr float kBossBulletSpeedEasy = 0.5F;
constexpr float kBossBulletSpeedHard = 0.75F;
constexpr int kBossBulletExpiry = 50;
constexpr float kBossBulletSpin = kPi / 8;   // radians per step
constexpr float kTrailVelocityShare = 0.5F;  // of the bullet's
constexpr float kTrailFading = 0.7F;
constexpr int kTrailExpiry = 8;

constexpr int kHealthPerRoundMax = 9;
constexpr int kRoundsMax = 5;
constexpr int kPatternCount = 4;
constexpr int kFanPeriod = 8;  // steps between salvos
constexpr int kFanBullets = 5;
constexpr int kCrossPeriod = 5;
constexpr int kCrossBullets = 4;
constexpr int kCrossSwing = 8;  // salvos from one end of the swing to the other
constexpr int kRingPeriod = 10;
constexpr int kRingBullets = 8;
constexpr int kStreamPeriod = 4;

constexpr int kMoveSteps = 20;         // the boss picks a destination one step after this many
constexpr float kDestinationXMin = 3;  // cells
constexpr float kDestinationXRange = 14;
constexpr float kDestinationYMin = 3;  // above kBarrierTop
constexpr float kDestinationYRange = 8;
constexpr int kShieldMovesMin = 2;  // moves until the shield drops
constexpr int kShieldMovesChoicesEasy = 2;
constexpr int kShieldMovesChoicesHard = 4;
constexpr int kOpenMoves = 500;          // moves without shield: longer than an episode
constexpr float kOpenShotChance = 0.1F;  // per step without shield
constexpr int kDamageShowSteps = 40;     // explosions after a round; the boss does not move
constexpr int kDamageShowPeriod = 3;
constexpr float kDamageRadius = 0.75F;
constexpr float kExplosionShare = 0.5F;  // of the half-width of the exploding entity

constexpr int kBarriersMax = 3;
constexpr float kBarrierHealth = 3;  // never decreases
constexpr float kBarrierTop = 6;     // barriers are below this height and above the agent
constexpr double kBarrierGap = 0.5;

constexpr float kRoundReward = 1;
constexpr float kBossReward = 10;

constexpr ArtSlot kArtSlots[] = {
    {0, 0, "agent", "misc_assets/playerShip1_blue.png", 99, 75},
    {0, 1, "agent", "misc_assets/playerShip1_green.png", 99, 75},
    {0, 2, "agent", "misc_assets/playerShip2_orange.png", 112, 75},
    {0, 3, "agent", "misc_assets/playerShip3_red.png", 98, 75},
    {1, 0, "player_bullet", "misc_assets/laserGreen14.png", 48, 46},
    {1, 1, "player_bullet", "misc_assets/laserRed11.png", 37, 37},
    {1, 2, "player_bullet", "misc_assets/laserBlue09.png", 48, 46},
    {2, 0, "boss", "misc_assets/enemyShipBlack1.png", 93, 84},
    {2, 1, "boss", "misc_assets/enemyShipBlue2.png", 104, 84},
    {2, 2, "boss", "misc_assets/enemyShipGreen3.png", 103, 84},
    {2, 3, "boss", "misc_assets/enemyShipRed4.png", 82, 84},
    {3, 0, "shield", "misc_assets/shield2.png", 143, 119},
    {4, 0, "boss_bullet", "misc_assets/laserGreen14.png", 48, 46},
    {4, 1, "boss_bullet", "misc_assets/laserRed11.png", 37, 37},
    {4, 2, "boss_bullet", "misc_assets/laserBlue09.png", 48, 46},
    {7, 0, "meteor", "misc_assets/spaceMeteors_001.png", 215, 211},
    {7, 1, "meteor", "misc_assets/spaceMeteors_002.png", 212, 218},
    {7, 2, "meteor", "misc_assets/spaceMeteors_003.png", 214, 227},
    {7, 3, "meteor", "misc_assets/spaceMeteors_004.png", 220, 221},
    {7, 4, "meteor", "misc_assets/meteorGrey_big1.png", 101, 84},
    {7, 5, "meteor", "misc_assets/meteorGrey_big2.png", 120, 98},
    {7, 6, "meteor", "misc_assets/meteorGrey_big3.png", 89, 82},
    {7, 7, "meteor", "misc_assets/meteorGrey_big4.png", 98, 96},
};

constexpr GameArtSpec kArt = {.slots = kArtSlots, .background_group = BackgroundGroup::kSpace};

class BossFight final : public Game {
 public:
  explicit BossFight(const GameOptions& options) : Game(kArt, options) { top_speed_ = kTopSpeed; }

 private:
  // --- Level generation: the boss and its attacks, the agent, barriers.

  void MakeLevel() override {
    StandardReset(kWorldSide, kWorldSide);
    center_agent_ = false;
    damage_show_end_ = 0;
    last_shot_step_ = 0;
    PlaceBoss();
    PlanFight();
    PlaceAgent();
    random_.Coin();  // not used
    const int32_t barrier_count = random_.Int(kBarriersMax) + 1;
    for (int32_t i = 0; i < barrier_count; ++i) {
      PlaceBarrier();
    }
  }

  void PlaceBoss() {
    const float center = kWorldSide / 2.0F;
    Entity& boss = world_.entities.emplace_back(
        Entity::Make(kBossKind, center, center, 0, 0, kBossRadius, kBossRadius));
    boss.theme = DrawTheme(kBossKind);
    boss.ry = kBossRadius / AspectRatio(kBossKind, boss.theme);
    boss.auto_remove = false;
    const auto shield_rx = static_cast<float>(kShieldShare * boss.rx);
    const auto shield_ry = static_cast<float>(kShieldShare * boss.ry);
    Entity& shield = world_.entities.emplace_back(
        Entity::Make(kShieldKind, center, center, 0, 0, shield_rx, shield_ry));
    shield.auto_remove = false;
  }

  void PlanFight() {
    const bool easy = options().distribution_mode == DistributionMode::kEasy;
    boss_bullet_speed_ = easy ? kBossBulletSpeedEasy : kBossBulletSpeedHard;
    health_per_round_ = random_.Int(kHealthPerRoundMax) + 1;
    const int32_t round_count = random_.Int(kRoundsMax) + 1;
    shield_moves_ =
        kShieldMovesMin + random_.Int(easy ? kShieldMovesChoicesEasy : kShieldMovesChoicesHard);
    Boss().health = static_cast<float>(health_per_round_ * round_count);
    world_.agent().theme = DrawTheme(kAgentKind);
    player_laser_theme_ = random_.Int(kLaserThemeCount);
    boss_laser_theme_ = random_.Int(kLaserThemeCount);
    patterns_.clear();
    for (int32_t i = 0; i < round_count; ++i) {
      patterns_.push_back(random_.Int(kPatternCount));
    }
    round_ = 0;
    BeginRound();
  }

  void BeginRound() {
    shield_is_up_ = true;
    steps_to_move_ = kMoveSteps;
    moves_left_ = shield_moves_;
    Boss().vx = 0;
    Boss().vy = 0;
  }

  void PlaceAgent() {
    Entity& agent = world_.agent();
    agent.rx = kAgentRadius;
    agent.ry = kAgentRadius / AspectRatio(kAgentKind, agent.theme);
    PlaceAgentAtRandom(world_, random_);
    agent.y = agent.ry;
  }

  // A barrier that would overlap something is omitted.
  void PlaceBarrier() {
    const auto bottom = static_cast<float>((2 * world_.agent().ry + kBarrierRadius) + kBarrierGap);
    const float y = random_.Unit() * ((kBarrierTop - bottom) - kBarrierRadius) + bottom;
    const float x = random_.Unit() * (kWorldSide - 2 * kBarrierRadius) + kBarrierRadius;
    Entity barrier = Entity::Make(kBarrierKind, x, y, 0, 0, kBarrierRadius, kBarrierRadius);
    barrier.theme = DrawTheme(kBarrierKind);
    barrier.ry = kBarrierRadius / AspectRatio(kBarrierKind, barrier.theme);
    barrier.health = kBarrierHealth;
    barrier.meets_entities = true;
    if (!OverlapsAnything(world_, barrier)) {
      world_.entities.push_back(barrier);
    }
  }

  // --- Step. The four draws are taken whether they are needed or not.

  void PlayStep() override {
    StandardStep();
    world_.entities[kShieldIndex].x = Boss().x;
    world_.entities[kShieldIndex].y = Boss().y;
    aim_ = random_.Unit();
    const float fire = random_.Unit();
    const float place_x = random_.Unit();
    const float place_y = random_.Unit();
    MoveBoss(place_x, place_y);
    if (special_action_ == 1 && step_number() - last_shot_step_ >= kShotPause) {
      Shoot();
    }
    if (damage_show_end_ >= step_number()) {
      ShowDamage(place_x, place_y);
    } else if (shield_is_up_) {
      Attack();
    } else if (fire < kOpenShotChance) {
      FireBossBullet(kPi * (1 + aim_));
    }
    LeaveTrails();
  }

  Entity& Boss() { return world_.entities[kBossIndex]; }

  // The boss flies from destination to destination. After some of them the shield changes.
  void MoveBoss(float place_x, float place_y) {
    if (steps_to_move_ > 0) {
      --steps_to_move_;
      return;
    }
    const float x = place_x * kDestinationXRange + kDestinationXMin;
    const float y = (place_y * kDestinationYRange + kDestinationYMin) + kBarrierTop;
    Boss().vx = (x - Boss().x) / kMoveSteps;
    Boss().vy = (y - Boss().y) / kMoveSteps;
    steps_to_move_ = kMoveSteps;
    if (moves_left_ > 0) {
      --moves_left_;
    } else {
      moves_left_ = shield_is_up_ ? kOpenMoves : shield_moves_;
      shield_is_up_ = !shield_is_up_;
    }
  }

  void Shoot() {
    const Entity& agent = world_.agent();
    Entity& bullet = world_.entities.emplace_back(
        Entity::Make(kPlayerBulletKind, agent.x, agent.y, 0, kPlayerBulletSpeed,
                     kPlayerBulletRadius, kPlayerBulletRadius));
    bullet.theme = player_laser_theme_;
    bullet.expiry = kPlayerBulletExpiry;
    bullet.meets_entities = true;
    last_shot_step_ = step_number();
  }

  void ShowDamage(float place_x, float place_y) {
    if (step_number() % kDamageShowPeriod != 0) {
      return;
    }
    const float x = Boss().x + (2 * place_x - 1) * Boss().rx;
    const float y = Boss().y + (2 * place_y - 1) * Boss().ry;
    world_.entities.push_back(
        Entity::Make(kExplosionKind, x, y, 0, 0, kDamageRadius, kDamageRadius));
  }

  // --- The boss's fire. Angles are counterclockwise from the right, computed partly in f64.

  void Attack() {
    switch (patterns_[static_cast<size_t>(round_) % patterns_.size()]) {
      case 0:
        return FireFan();
      case 1:
        return FireSwingingCross();
      case 2:
        return FireRing();
      default:
        return FireStream();
    }
  }

  void FireFan() {
    if (step_number() % kFanPeriod != 0) {
      return;
    }
    for (int i = 0; i < kFanBullets; ++i) {
      const float spread = (static_cast<float>(i - 2) * kPi) / 8;
      FireBossBullet(static_cast<float>(kPi * 1.5 + spread));
    }
  }

  void FireSwingingCross() {
    if (step_number() % kCrossPeriod != 0) {
      return;
    }
    const int32_t salvo = step_number() / kCrossPeriod;
    const int32_t swing = std::abs(kCrossSwing - salvo % (2 * kCrossSwing));
    for (int i = 0; i < kCrossBullets; ++i) {
      const float arm = (static_cast<float>(i) * kPi) / 2;
      FireBossBullet(static_cast<float>(kPi * (1.25 + (0.5 * swing) / kCrossSwing) + arm));
    }
  }

  void FireRing() {
    if (step_number() % kRingPeriod != 0) {
      return;
    }
    const float offset = (aim_ * 2) * kPi;
    for (int i = 0; i < kRingBullets; ++i) {
      FireBossBullet(((2 * kPi) / kRingBullets) * static_cast<float>(i) + offset);
    }
  }

  void FireStream() {
    if (step_number() % kStreamPeriod == 0) {
      FireBossBullet(kPi * (1 + aim_));
    }
  }

  void FireBossBullet(float angle) {
    const double speed = boss_bullet_speed_;
    const auto vx = static_cast<float>(speed * std::cos(static_cast<double>(angle)));
    const auto vy = static_cast<float>(speed * std::sin(static_cast<double>(angle)));
    Entity& bullet = SpawnChild(world_, kBossBulletKind, kBossBulletRadius, Boss(), false);
    bullet.vx = vx;
    bullet.vy = vy;
    bullet.theme = boss_laser_theme_;
    bullet.expiry = kBossBulletExpiry;
    bullet.spin = kBossBulletSpin;
  }

  void LeaveTrails() {
    for (size_t i = world_.entities.size(); i-- > 0;) {
      if (world_.entities[i].kind != kBossBulletKind) {
        continue;
      }
      const Entity bullet = world_.entities[i];
      Entity& piece = SpawnChild(world_, kTrailPieceKind, bullet.rx, bullet, false);
      piece.vx = bullet.vx * kTrailVelocityShare;
      piece.vy = bullet.vy * kTrailVelocityShare;
      piece.image_kind = kBossBulletKind;
      piece.theme = boss_laser_theme_;
      piece.rotation = bullet.rotation;
      piece.spin = bullet.spin;
      piece.fading = kTrailFading;
      piece.expiry = kTrailExpiry;
    }
  }

  // --- Contacts. The boss has already moved, its shield has not.

  void OnAgentContact(Entity& other) override {
    if (other.kind == kBossKind || other.kind == kBossBulletKind || other.kind == kBarrierKind) {
      outcome_.done = true;
    }
  }

  void OnEntityContact(Entity& self, Entity& other) override {
    if (self.kind == kPlayerBulletKind) {
      if (other.kind == kShieldKind && shield_is_up_) {
        Reflect(self);
      } else if (other.kind == kBossKind && !shield_is_up_) {
        HitBoss(self);
      }
    } else if (self.kind == kBarrierKind) {
      StopAtBarrier(other);
    }
  }

  // A reflected bullet is harmless and expires soon. Its direction is from a draw of the last step.
  void Reflect(Entity& bullet) const {
    bullet.kind = kReflectedBulletKind;
    const auto angle = static_cast<float>(kPi * (1.25 + 0.5 * aim_));
    bullet.vx = static_cast<float>(std::cos(static_cast<double>(angle)) * kReflectedSpeed);
    bullet.vy = static_cast<float>(std::sin(static_cast<double>(angle)) * kReflectedSpeed);
    bullet.life_time = 0;
    bullet.expiry = kReflectedExpiry;
    bullet.fading = kReflectedFading;
  }

  void HitBoss(Entity& bullet) {
    Boss().health -= 1;
    const auto health = static_cast<int32_t>(Boss().health);
    if (health % health_per_round_ == 0) {
      outcome_.reward += kRoundReward;
      if (health == 0) {
        outcome_.reward += kBossReward;
        outcome_.level_complete = true;
        outcome_.done = true;
      } else {
        ++round_;
        BeginRound();
        steps_to_move_ = kDamageShowSteps;
        damage_show_end_ = step_number() + kDamageShowSteps;
      }
    }
    bullet.marked = true;
    Entity& explosion =
        SpawnChild(world_, kExplosionKind, kExplosionShare * bullet.rx, bullet, false);
    explosion.vx = Boss().vx;
    explosion.vy = Boss().vy;
  }

  void StopAtBarrier(Entity& other) {
    if (other.kind == kBossBulletKind || other.kind == kPlayerBulletKind) {
      other.marked = true;
      SpawnChild(world_, kExplosionKind, kExplosionShare * other.rx, other, false);
    } else if (other.kind == kTrailPieceKind) {
      other.marked = true;
    }
  }

  // --- Appearance.

  int ImageKindOf(const Entity& entity) const override {
    return entity.kind == kShieldKind && !shield_is_up_ ? -1 : Game::ImageKindOf(entity);
  }

  void VisitOwnState(StateArchive& archive) override {
    archive.Int("round", round_, 0, kRoundsMax);
    archive.Bool("shield_is_up", shield_is_up_);
    archive.Int("moves_left", moves_left_, 0, kOpenMoves);
    archive.Int("steps_to_move", steps_to_move_, 0, kDamageShowSteps);
    archive.Int("damage_show_end", damage_show_end_, 0, kRememberedStepMax);
    archive.Int("last_shot_step", last_shot_step_, 0, kRememberedStepMax);
    archive.Float("aim", aim_, 0, 1);
    archive.Check(world_.entities.size() > kShieldIndex &&
                      IsThereForGood(world_.entities[kBossIndex], kBossKind) &&
                      IsThereForGood(world_.entities[kShieldIndex], kShieldKind),
                  "has no boss and shield that stay, as entities 1 and 2");
  }

  float boss_bullet_speed_ = kBossBulletSpeedHard;  // cells per step
  int32_t health_per_round_ = 1;
  std::vector<int32_t> patterns_;  // attack patterns, by round
  int32_t round_ = 0;
  bool shield_is_up_ = true;
  int32_t shield_moves_ = 0;     // moves of the boss with shield, in each round
  int32_t moves_left_ = 0;       // moves until the shield changes
  int32_t steps_to_move_ = 0;    // steps until the boss picks its next destination
  int32_t damage_show_end_ = 0;  // step
  int32_t last_shot_step_ = 0;
  int32_t player_laser_theme_ = 0;
  int32_t boss_laser_theme_ = 0;
  float aim_ = 0;  // drawn in each step
};

}  // namespace

extern constexpr GameSpec kBossFight = {
    .name = "bossfight",
    .description = "A ship dodges a boss's bullets and fires back when its shield is down.",
    .modes = kEasyHard,
    .step_limit = 4000,
    .easy_returns = {0.5, 13},
    .hard_returns = {0.5, 13},
    .special_actions = kSpecialActions,
    .kinds = kKinds,
    .make = MakeGame<BossFight>,
};

}  // namespace procgen
