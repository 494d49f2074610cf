// Plunder: a ship at the bottom of the sea fires cannon balls straight up at ships that cross in
// five lanes. Hitting the type in the legend, bottom left, pays +1 and refills the reserve. Other
// hits, each shot and time drain the reserve. The episode ends when the reserve is empty or,
// complete, with the 20th correct hit (+10).

#include <algorithm>
#include <array>
#include <numeric>
#include <vector>

#include "envcore/games/game.h"
#include "envcore/games/game_spec.h"
#include "envcore/world/direction.h"
#include "envcore/world/placing.h"
#include "envcore/world/world_state.h"

namespace procgen {
namespace {

constexpr int kBallKind = 1;
constexpr int kLegendShipKind = 2;
constexpr int kLegendDiscKind = 3;
constexpr int kPanelKind = 6;  // absorbs balls
constexpr int kShipKind = 7;   // also the image of the agent and the legend ship

constexpr KindName kKinds[] = {{kBallKind, "cannon_ball"},
                               {kLegendShipKind, "target_sign"},
                               {kLegendDiscKind, "target_disc"},
                               {kPanelKind, "panel"},
                               {kShipKind, "ship"}};

constexpr SpecialAction kSpecialActions[] = {
    {9, "Fires a cannon ball upwards, at most once in 3 steps."}};

constexpr int kWorldSide = 20;           // cells
constexpr float kShipRadiusEasy = 1.5F;  // half-widths; the heights follow the art
constexpr float kShipRadiusHard = 1;
constexpr float kTopSpeed = 0.85F;        // cells per step
constexpr float kAgentBottom = 1;         // cells below the agent
constexpr float kLegendRadius = 2;        // of the disc in the corner
constexpr float kLegendCenter = 2;        // x and y
constexpr float kLegendShipShare = 1.5F;  // of a ship's size
constexpr int kPanelChoices = 4;          // 0 to 3 panels in hard levels
constexpr float kPanelRadiusX = 1.2F;
constexpr float kPanelRadiusY = 0.5F;
constexpr Box kPanelBox = {.x = 0, .y = 5, .width = kWorldSide, .height = 5};

constexpr int kShipTypeCount = 6;
constexpr int kShipTypesInUse = 2;  // the first is the target, the other is the agent's own
constexpr int kOwnTypes = kShipTypesInUse - 1;
constexpr size_t kLaneCount = 5;
constexpr double kLaneBottom = 0.4;  // in fractions of the lanes' height
constexpr double kLaneSpacing = 0.11;
constexpr float kLanesBottom = 10;      // cells
constexpr float kLanesHeight = 10;      // minus a ship's half-width
constexpr double kLaneSpeedMin = 0.15;  // cells per step
constexpr double kLaneSpeedRange = 0.1;
constexpr float kShipChance = 0.06F;  // per step, for a ship that tries to enter

constexpr float kBallRadius = 0.25F;
constexpr float kBallSpeed = 1;
constexpr int kBallExpiry = 50;          // steps
constexpr int kShotPause = 3;            // least steps from one shot to the next
constexpr float kExplosionShare = 0.5F;  // of the half-width of the ship
constexpr float kExplosionVelocityShare = 0.5F;

constexpr int kHitsNeeded = 20;
constexpr float kHitReward = 1;
constexpr float kCompletionReward = 10;
constexpr float kReserveRange = 100;  // limit in a snapshot, either sign
constexpr int kHitsMax = 1000;        // limit in a snapshot
constexpr float kReserveMax = 1;
constexpr float kStepCost = 0.0015F;  // of the reserve
constexpr float kShotCost = 0.02F;
constexpr float kHitGain = 0.1F;
constexpr float kWrongHitCost = 0.1F;

constexpr float kBarLeft = 0.25F;  // cells from the top left corner of the image
constexpr float kReserveBarTop = 0.25F;
constexpr float kHitsBarTop = 0.75F;
constexpr float kBarHeight = 0.5F;
constexpr std::array<uint8_t, 3> kReserveColor = {66, 245, 135};
constexpr std::array<uint8_t, 3> kHitsColor = {245, 66, 144};

constexpr ArtSlot kArtSlots[] = {
    {1, 0, "cannon_ball", "misc_assets/cannonBall.png", 10, 10},
    {3, 0, "target_disc", "misc_assets/target_red2.png", 128, 128},
    {6, 0, "panel", "misc_assets/panel_wood.png", 128, 128},
    {7, 0, "ship", "misc_assets/ship_1.png", 113, 66},
    {7, 1, "ship", "misc_assets/ship_2.png", 113, 66},
    {7, 2, "ship", "misc_assets/ship_3.png", 113, 66},
    {7, 3, "ship", "misc_assets/ship_4.png", 113, 66},
    {7, 4, "ship", "misc_assets/ship_5.png", 113, 66},
    {7, 5, "ship", "misc_assets/ship_6.png", 113, 66},
};

constexpr int kKeptThemeKinds[] = {kShipKind};  // the theme is the type

constexpr GameArtSpec kArt = {.slots = kArtSlots,
                              .kept_theme_kinds = kKeptThemeKinds,
                              .background_group = BackgroundGroup::kWaterSurface};

struct Lane {
  bool to_right = true;
  float speed = 0;  // cells per step
};

class Plunder final : public Game {
 public:
  explicit Plunder(const GameOptions& options)
      : Game(kArt, options),
        is_easy_(options.distribution_mode == DistributionMode::kEasy),
        ship_radius_(is_easy_ ? kShipRadiusEasy : kShipRadiusHard) {
    top_speed_ = kTopSpeed;
    shows_velocity_ = false;
  }

 private:
  // --- Level generation.

  void MakeLevel() override {
    StandardReset(kWorldSide, kWorldSide);
    center_agent_ = false;
    world_.agent().image_kind = kShipKind;
    reserve_ = kReserveMax;
    hits_ = 0;
    last_shot_step_ = 0;
    std::vector<int32_t> all_types(kShipTypeCount);
    std::iota(all_types.begin(), all_types.end(), 0);
    ship_types_ = random_.NOf(all_types, kShipTypeCount);
    for (Lane& lane : lanes_) {
      lane.to_right = random_.Unit() < 0.5F;
      const double speed_share = random_.Unit();
      lane.speed = static_cast<float>(kLaneSpeedMin + kLaneSpeedRange * speed_share);
    }
    PlacePanels();
    PlaceLegend();
    PlaceAgent();
  }

  void PlacePanels() {
    if (is_easy_) {
      return;
    }
    const int32_t panel_count = random_.Int(kPanelChoices);
    for (int32_t i = 0; i < panel_count; ++i) {
      SpawnInBox(world_, random_, kPanelKind, kPanelRadiusX, kPanelRadiusY, kPanelBox);
    }
  }

  // Shows the target type on a disc.
  void PlaceLegend() {
    world_.entities.push_back(Entity::Make(kLegendDiscKind, kLegendCenter, kLegendCenter, 0, 0,
                                           kLegendRadius, kLegendRadius));
    Entity ship = MakeShip(kLegendShipKind, TargetType(), ship_radius_ * kLegendShipShare);
    ship.x = kLegendCenter;
    ship.y = kLegendCenter;
    ship.rotation = kHalfPi;
    world_.entities.push_back(ship);
  }

  void PlaceAgent() {
    Entity& agent = world_.agent();
    agent.rx = ship_radius_;
    agent.rotation = -kHalfPi;
    const int32_t own_type = random_.Int(kOwnTypes);
    agent.theme = ship_types_[1 + static_cast<size_t>(own_type)];
    agent.ry = agent.rx / AspectRatio(kShipKind, agent.theme);
    PlaceAgentAtRandom(world_, random_);
    agent.y = kAgentBottom + agent.ry;
    KeepAgentOffLegend();
  }

  void KeepAgentOffLegend() {
    Entity& agent = world_.agent();
    agent.x = std::max(agent.x, 2 * kLegendRadius + ship_radius_);
  }

  int32_t TargetType() const { return ship_types_[0]; }

  // Makes an entity with the image of a ship of `type`, at rest. The caller sets its position.
  Entity MakeShip(int kind, int32_t type, float radius) const {
    Entity ship = Entity::Make(kind, 0, 0, 0, 0, radius, radius / AspectRatio(kShipKind, type));
    ship.image_kind = kShipKind;
    ship.theme = type;
    return ship;
  }

  // --- Step.

  void MapControls() override { world_.controls.vertical = 0; }

  void PlayStep() override {
    StandardStep();
    reserve_ -= kStepCost;
    if (random_.Unit() < kShipChance) {
      SendShip();
    }
    if (special_action_ == 1 && step_number() - last_shot_step_ >= kShotPause) {
      Shoot();
    }
    if (reserve_ <= 0) {
      outcome_.done = true;
    } else if (reserve_ > kReserveMax) {
      reserve_ = kReserveMax;
    }
    if (hits_ >= kHitsNeeded) {
      outcome_.done = true;
      outcome_.reward += kCompletionReward;
      outcome_.level_complete = true;
    }
    KeepAgentOffLegend();
  }

  // Adds a ship to a lane, if there is room.
  void SendShip() {
    const int32_t lane_index = random_.Int(static_cast<int32_t>(kLaneCount));
    const Lane& lane = lanes_[static_cast<size_t>(lane_index)];
    const int32_t type_index = random_.Int(kShipTypesInUse);
    Entity ship = MakeShip(kShipKind, ship_types_[static_cast<size_t>(type_index)], ship_radius_);
    ship.x = lane.to_right ? -ship_radius_ : kWorldSide + ship_radius_;
    ship.y = static_cast<float>(
        (lane_index * kLaneSpacing + kLaneBottom) * (kLanesHeight - ship_radius_) + kLanesBottom);
    ship.vx = lane.to_right ? lane.speed : -lane.speed;
    ship.mirrored = !lane.to_right;
    if (!OverlapsAnything(world_, ship)) {
      world_.entities.push_back(ship);
    }
  }

  void Shoot() {
    const Entity& agent = world_.agent();
    Entity& ball = world_.entities.emplace_back(
        Entity::Make(kBallKind, agent.x, agent.y, 0, kBallSpeed, kBallRadius, kBallRadius));
    ball.expiry = kBallExpiry;
    ball.meets_entities = true;
    last_shot_step_ = step_number();
    reserve_ -= kShotCost;
  }

  // --- Contacts. Only balls test for contacts.

  void OnEntityContact(Entity& self, Entity& other) override {
    if (other.kind == kShipKind) {
      self.marked = true;
      SinkShip(other);
    } else if (other.kind == kPanelKind) {
      self.marked = true;
    }
  }

  void SinkShip(Entity& ship) {
    ship.marked = true;
    if (ship.theme == TargetType()) {
      ++hits_;
      outcome_.reward += kHitReward;
      reserve_ += kHitGain;
    } else {
      reserve_ -= kWrongHitCost;
    }
    Entity& explosion = SpawnChild(world_, kExplosionKind, kExplosionShare * ship.rx, ship, true);
    explosion.vx *= kExplosionVelocityShare;
    explosion.vy *= kExplosionVelocityShare;
  }

  // --- Appearance: two bars at the top, full when they reach the right edge.

  void AddOverlays(std::vector<Overlay>* overlays) const override {
    const auto hits_width =
        static_cast<float>(kWorldSide * (static_cast<double>(hits_) / kHitsNeeded));
    AddBar(kReserveBarTop, kWorldSide * reserve_, kReserveColor, overlays);
    AddBar(kHitsBarTop, hits_width, kHitsColor, overlays);
  }

  static void AddBar(float top, float width, const std::array<uint8_t, 3>& color,
                     std::vector<Overlay>* overlays) {
    overlays->push_back({.shape = Overlay::Shape::kRectangle,
                         .x = kBarLeft,
                         .y = top,
                         .width = width,
                         .height = kBarHeight,
                         .color = color});
  }

  void VisitOwnState(StateArchive& archive) override {
    archive.Float("reserve", reserve_, -kReserveRange, kReserveRange);
    archive.Int("hits", hits_, 0, kHitsMax);
    archive.Int("last_shot_step", last_shot_step_, 0, kRememberedStepMax);
  }

  bool is_easy_;
  float ship_radius_;                // half-width, cells
  std::vector<int32_t> ship_types_;  // in drawn order
  std::array<Lane, kLaneCount> lanes_;
  float reserve_ = kReserveMax;  // a fraction
  int32_t hits_ = 0;             // correct hits
  int32_t last_shot_step_ = 0;
};

}  // namespace

extern constexpr GameSpec kPlunder = {
    .name = "plunder",
    .description = "A ship fires at enemy ships and spares friendly ones.",
    .modes = kEasyHard,
    .step_limit = 4000,
    .easy_returns = {4.5, 30},
    .hard_returns = {3, 30},
    .special_actions = kSpecialActions,
    .kinds = kKinds,
    .make = MakeGame<Plunder>,
};

}  // namespace procgen
