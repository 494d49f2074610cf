// Leaper: a frog hops, cell by cell, over lanes of road with cars and lanes of water with floating
// logs to the finish line (+10, level complete). Touching a car, water without a log, or being
// carried out of the world ends the episode.

#include <algorithm>
#include <cmath>

#include "envcore/games/game.h"
#include "envcore/games/game_spec.h"
#include "envcore/world/direction.h"

namespace procgen {
namespace {

constexpr int kLogKind = 1;
constexpr int kRoadKind = 2;
constexpr int kWaterKind = 3;
constexpr int kCarKind = 4;
constexpr int kFinishKind = 5;

constexpr KindName kKinds[] = {{kLogKind, "log"},
                               {kRoadKind, "road"},
                               {kWaterKind, "water"},
                               {kCarKind, "car"},
                               {kFinishKind, "finish", true}};

constexpr float kCarRadiusX = 0.5F;  // cells
constexpr float kCarRadiusY = 0.25F;
constexpr float kLogRadius = 0.45F;
constexpr float kFinishRadiusY = 0.5F;
constexpr float kCarEntry = 0.25F;  // cells outside the world at which centers appear
constexpr float kLogEntry = 0.45F;
constexpr float kCarSpacing = 6;  // mean distance between arrivals in a lane, cells
constexpr float kLogSpacing = 2;
constexpr float kHopSpeed = 0.5F;     // at the start of a hop, cells per step
constexpr float kHopSlowdown = 0.1F;  // subtracted in each step
constexpr int kFrogPictureCount = 5;  // of a hop; a sitting frog shows image 0
constexpr float kFinishReward = 10;

constexpr int kExtraRowChoices = 2;   // rows of grass; not drawn in easy mode
constexpr int kExtraLaneChoices = 4;  // likewise; two of the values add a lane
constexpr int kExtraLaneIsRoad = 2;
constexpr int kExtraLaneIsWater = 3;

constexpr ArtSlot kArtSlots[] = {
    {0, 0, "frog", "misc_assets/frog1.png", 91, 144},
    {0, 1, "frog", "misc_assets/frog2.png", 93, 144},
    {0, 2, "frog", "misc_assets/frog4.png", 93, 144},
    {0, 3, "frog", "misc_assets/frog6.png", 94, 144},
    {0, 4, "frog", "misc_assets/frog7.png", 93, 144},
    {1, 0, "log", "misc_assets/elementWood044.png", 70, 70},
    {2, 0, "road", "misc_assets/roadTile6b.png", 64, 48},
    {3, 0, "water", "misc_assets/terrainTile6.png", 64, 64},
    {4, 0, "car", "misc_assets/car_yellow_5.png", 121, 70},
    {4, 1, "car", "misc_assets/car_black_1.png", 131, 71},
    {4, 2, "car", "misc_assets/car_blue_2.png", 116, 71},
    {4, 3, "car", "misc_assets/car_green_3.png", 131, 70},
    {4, 4, "car", "misc_assets/car_red_4.png", 131, 70},
    {5, 0, "finish", "misc_assets/finish2.png", 16, 16},
};

constexpr int kBlockShapedKinds[] = {kRoadKind, kWaterKind};
constexpr int kKeptThemeKinds[] = {kAgentKind};  // its themes are the images of a hop

constexpr GameArtSpec kArt = {.slots = kArtSlots,
                              .block_shaped_kinds = kBlockShapedKinds,
                              .kept_theme_kinds = kKeptThemeKinds,
                              .background_group = BackgroundGroup::kTopdown};

struct ModeFigures {
  int side;             // of the world, cells
  int lane_choices;     // lanes of each type: 0 to lane_choices - 1
  bool has_extras;      // random rows of grass and an additional lane
  int warm_up_rounds;   // of traffic before the first step
  float car_speed_min;  // cells per step
  float car_speed_max;
  float log_speed_min;
  float log_speed_max;
};

constexpr ModeFigures kEasyFigures = {.side = 9,
                                      .lane_choices = 4,
                                      .has_extras = false,
                                      .warm_up_rounds = 360,
                                      .car_speed_min = 0.03F,
                                      .car_speed_max = 0.12F,
                                      .log_speed_min = 0.025F,
                                      .log_speed_max = 0.075F};
constexpr ModeFigures kHardFigures = {.side = 15,
                                      .lane_choices = 5,
                                      .has_extras = true,
                                      .warm_up_rounds = 300,
                                      .car_speed_min = 0.05F,
                                      .car_speed_max = 0.2F,
                                      .log_speed_min = 0.05F,
                                      .log_speed_max = 0.1F};
constexpr ModeFigures kExtremeFigures = {.side = 20,
                                         .lane_choices = 5,
                                         .has_extras = true,
                                         .warm_up_rounds = 200,
                                         .car_speed_min = 0.1F,
                                         .car_speed_max = 0.3F,
                                         .log_speed_min = 0.1F,
                                         .log_speed_max = 0.2F};

const ModeFigures& FiguresOf(DistributionMode mode) {
  switch (mode) {
    case DistributionMode::kEasy:
      return kEasyFigures;
    case DistributionMode::kExtreme:
      return kExtremeFigures;
    default:
      return kHardFigures;
  }
}

// `speed` one step later in a hop.
float Slowed(float speed) {
  const float slower = std::max(0.0F, std::fabs(speed) - kHopSlowdown);
  return speed < 0 ? -slower : slower;
}

class Leaper final : public Game {
 public:
  explicit Leaper(const GameOptions& options)
      : Game(kArt, options), figures_(FiguresOf(options.distribution_mode)) {}

 private:
  // --- Level generation, from the bottom up: grass, roads, grass, water, the finish line. Then the
  // traffic runs until it has reached a steady flow.

  void MakeLevel() override {
    const int side = figures_.side;
    StandardReset(side, side);
    center_agent_ = false;
    world_.agent().y = world_.agent().ry;

    const int grass_below_road = DrawExtra(kExtraRowChoices);
    const int lane_count = random_.Int(figures_.lane_choices);
    const int extra_lane = DrawExtra(kExtraLaneChoices);
    first_road_row_ = 1 + grass_below_road;
    MakeRoad(lane_count + (extra_lane == kExtraLaneIsRoad ? 1 : 0));
    const int grass_below_water = DrawExtra(kExtraRowChoices);
    first_water_row_ =
        first_road_row_ + static_cast<int>(road_speeds_.size()) + 1 + grass_below_water;
    MakeWater(lane_count + (extra_lane == kExtraLaneIsWater ? 1 : 0));

    for (int round = 0; round < figures_.warm_up_rounds; ++round) {
      RunTraffic();
      MoveEntities();
    }
    const float half_side = static_cast<float>(side) / 2;
    const auto finish_row =
        static_cast<float>(first_water_row_ + static_cast<int>(water_speeds_.size()));
    world_.entities.push_back(Entity::Make(kFinishKind, half_side, finish_row + kFinishRadiusY, 0,
                                           0, half_side, kFinishRadiusY));
  }

  int DrawExtra(int choices) { return figures_.has_extras ? random_.Int(choices) : 0; }

  float DrawSign() { return random_.Unit() < 0.5F ? 1.0F : -1.0F; }

  void MakeRoad(int lane_count) {
    road_speeds_.clear();
    for (int lane = 0; lane < lane_count; ++lane) {
      const float sign = DrawSign();
      const float speed = random_.Range(figures_.car_speed_min, figures_.car_speed_max);
      road_speeds_.push_back(sign * speed);
      world_.grid.Fill(0, first_road_row_ + lane, figures_.side, 1, kRoadKind);
    }
  }

  // Neighboring lanes flow in opposite directions.
  void MakeWater(int lane_count) {
    water_speeds_.clear();
    float sign = DrawSign();
    for (int lane = 0; lane < lane_count; ++lane) {
      const float speed = random_.Range(figures_.log_speed_min, figures_.log_speed_max);
      water_speeds_.push_back(sign * speed);
      sign = -sign;
      world_.grid.Fill(0, first_water_row_ + lane, figures_.side, 1, kWaterKind);
    }
  }

  // --- Traffic: in each lane a car or log enters from time to time, if there is room for it.

  void RunTraffic() {
    float row = static_cast<float>(first_road_row_) + 0.5F;
    for (const float speed : road_speeds_) {
      if (random_.Unit() < std::fabs(speed) / kCarSpacing) {
        Entity car = Entity::Make(kCarKind, EntryOf(speed, kCarEntry), row, speed, 0, kCarRadiusX,
                                  kCarRadiusY);
        car.theme = DrawTheme(kCarKind);
        car.rotation = speed < 0 ? kPi : 0;
        AddWhereFree(car);
      }
      row += 1;
    }
    row = static_cast<float>(first_water_row_) + 0.5F;
    for (const float speed : water_speeds_) {
      if (random_.Unit() < std::fabs(speed) / kLogSpacing) {
        AddWhereFree(Entity::Make(kLogKind, EntryOf(speed, kLogEntry), row, speed, 0, kLogRadius,
                                  kLogRadius));
      }
      row += 1;
    }
  }

  float EntryOf(float speed, float distance) const {
    return speed > 0 ? -distance : static_cast<float>(figures_.side) + distance;
  }

  void AddWhereFree(const Entity& entity) {
    const bool collides =
        std::any_of(world_.entities.begin(), world_.entities.end(),
                    [&entity](const Entity& other) { return Overlap(entity, other, 0); });
    if (!collides) {
      world_.entities.push_back(entity);
    }
  }

  // --- Step.

  void PlayStep() override {
    int& picture = world_.agent().theme;
    if (picture != 0) {
      picture = (picture + 1) % kFrogPictureCount;
    }
    StandardStep();
    RunTraffic();
    Float();
  }

  // A frog at rest may begin a hop, sideways before up or down. Then every hop slows down.
  void UpdateAgentVelocity() override {
    Entity& frog = world_.agent();
    if (IsAtRest(frog)) {
      const Controls& controls = world_.controls;
      if (controls.horizontal != 0) {
        frog.vx = kHopSpeed * controls.horizontal;
        frog.rotation = controls.horizontal > 0 ? kHalfPi : -kHalfPi;
        frog.theme = 1;
      } else if (controls.vertical != 0) {
        frog.vy = kHopSpeed * controls.vertical;
        frog.rotation = controls.vertical > 0 ? 0 : kPi;
        frog.theme = 1;
      }
    }
    frog.vx = Slowed(frog.vx);
    frog.vy = Slowed(frog.vy);
  }

  static bool IsAtRest(const Entity& frog) { return frog.vx == 0 && frog.vy == 0; }

  // Logs carry the frog, hopping or not. Without one it must not come to rest over water.
  void Float() {
    Entity& frog = world_.agent();
    const Entity* log = nullptr;
    for (const Entity& entity : world_.entities) {
      if (entity.kind == kLogKind && Overlap(entity, frog, -frog.rx)) {
        log = &entity;
      }
    }
    const int cell = world_.CellAt(static_cast<int>(frog.x), static_cast<int>(frog.y));
    if (log != nullptr) {
      frog.x += log->vx;
    } else if (cell == kWaterKind && IsAtRest(frog)) {
      outcome_.done = true;
    }
    if (world_.IsOutside(frog)) {
      outcome_.done = true;
    }
  }

  void OnAgentContact(Entity& other) override {
    if (other.kind == kCarKind) {
      outcome_.done = true;
    } else if (other.kind == kFinishKind && IsAtRest(world_.agent())) {
      outcome_.reward += kFinishReward;
      outcome_.level_complete = true;
      outcome_.done = true;
    }
  }

  // --- Appearance.

  // The frog's image is higher than wide: it extends above and below the box.
  void StyleSprite(const Entity& entity, Sprite* sprite) const override {
    if (entity.kind == kAgentKind) {
      sprite->art_top = -0.275;
      sprite->art_height = 1.55;
    } else if (entity.kind == kFinishKind) {
      sprite->tile_ratio = 1;
    }
  }

  const ModeFigures& figures_;
  int first_road_row_ = 0;
  int first_water_row_ = 0;
  std::vector<float> road_speeds_;  // by lane from below; negative: to the left
  std::vector<float> water_speeds_;
};

}  // namespace

extern constexpr GameSpec kLeaper = {
    .name = "leaper",
    .description = "A frog crosses roads of cars and rivers of logs.",
    .modes = kWithExtreme,
    .step_limit = 500,
    .easy_returns = {3, 10},
    .hard_returns = {1.5, 10},
    .exploration_level = 1318677581,
    .kinds = kKinds,
    .make = MakeGame<Leaper>,
};

}  // namespace procgen
