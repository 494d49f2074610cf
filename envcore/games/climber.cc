// Climber: a tall, narrow side-view platform game. The player jumps from platform to platform and
// collects crystals (+1 each); the last one completes the level (+10). Touching a flying fish ends
// the episode. Falling is harmless.

#include <cmath>
#include <vector>

#include "envcore/games/game.h"
#include "envcore/games/game_spec.h"
#include "envcore/world/placing.h"
#include "envcore/world/support.h"

namespace procgen {
namespace {

constexpr int kCrystalKind = 1;
constexpr int kFishKind = 5;
constexpr int kFishImageKind = 6;  // image kinds: second frames, poses
constexpr int kFishTailClosedImageKind = 7;
constexpr int kPlayerJumpImageKind = 9;
constexpr int kPlayerWalkTogetherImageKind = 12;
constexpr int kPlayerWalkApartImageKind = 13;
constexpr int kRockKind = 15;  // the sides and the top; also everything outside the world
constexpr int kPlatformKind = 16;

constexpr KindName kKinds[] = {{kCrystalKind, "crystal", true},
                               {kFishKind, "fish"},
                               {kRockKind, "rock"},
                               {kPlatformKind, "platform"}};

constexpr int kWorldWidthEasy = 16;  // cells
constexpr int kWorldWidthHard = 20;
constexpr int kWorldHeight = 64;
constexpr float kAgentRadius = 0.5F;  // cells
constexpr float kAgentStart = 1.5F;   // both x and y
constexpr float kFishRadius = 0.5F;   // half-width; the half-height follows the art
constexpr float kCrystalRadius = 0.3F;

constexpr float kMix = 0.5F;            // weight of the new velocity, with support
constexpr float kAirMixFactor = 0.15F;  // without support
constexpr float kTopSpeed = 0.5F;       // cells per step
constexpr float kJumpSpeed = 1.5F;
constexpr float kGravity = 0.2F;    // cells per step, in each step without support
constexpr float kFallSpeedMax = 2;  // gravity adds nothing beyond this
constexpr double kFishSpeed = 0.15;
constexpr float kPatrolReach = 4;  // cells to either side
constexpr float kCrystalReward = 1;
constexpr float kCompletionReward = 10;
constexpr int kFrameSteps = 5;           // steps per frame of a walk
constexpr double kStandingSpeed = 0.01;  // slower counts as standing

constexpr int kWallThemeCount = 4;
constexpr int kRiseMin = 3;       // rows from one platform to the next; a jump reaches 5
constexpr int kRiseCount = 3;     // number of different rises
constexpr int kLengthMin = 2;     // of a platform, cells
constexpr int kLengthCount = 10;  // number of different lengths
constexpr int kTurnMargin = 3;    // a platform that starts closer to a side leads away from it
constexpr float kFishChanceEasy = 0.2F;  // per platform that does not start at a side
constexpr float kFishChanceHard = 0.5F;
constexpr float kCrystalChance = 0.5F;  // per platform but the last, which always has one
constexpr int kViewFeetMargin = 5;      // half-heights from the lower edge of the view to the agent

constexpr ArtSlot kArtSlots[] = {
    {0, 0, "player_stand", "platformer/playerBlue_stand.png", 45, 54},
    {0, 1, "player_stand", "platformer/playerGreen_stand.png", 38, 50},
    {0, 2, "player_stand", "platformer/playerGrey_stand.png", 36, 45},
    {0, 3, "player_stand", "platformer/playerRed_stand.png", 39, 48},
    {1, 0, "crystal", "platformer/yellowCrystal.png", 32, 30},
    {6, 0, "fish", "platformer/enemySwimming_1.png", 44, 32},
    {7, 0, "fish_tail_closed", "platformer/enemySwimming_2.png", 44, 32},
    {9, 0, "player_jump", "platformer/playerBlue_walk4.png", 49, 45},
    {9, 1, "player_jump", "platformer/playerGreen_walk4.png", 48, 43},
    {9, 2, "player_jump", "platformer/playerGrey_walk4.png", 48, 36},
    {9, 3, "player_jump", "platformer/playerRed_walk4.png", 49, 42},
    {12, 0, "player_walk_together", "platformer/playerBlue_walk1.png", 45, 54},
    {12, 1, "player_walk_together", "platformer/playerGreen_walk1.png", 38, 50},
    {12, 2, "player_walk_together", "platformer/playerGrey_walk1.png", 36, 45},
    {12, 3, "player_walk_together", "platformer/playerRed_walk1.png", 39, 48},
    {13, 0, "player_walk_apart", "platformer/playerBlue_walk2.png", 45, 54},
    {13, 1, "player_walk_apart", "platformer/playerGreen_walk2.png", 38, 48},
    {13, 2, "player_walk_apart", "platformer/playerGrey_walk2.png", 37, 43},
    {13, 3, "player_walk_apart", "platformer/playerRed_walk2.png", 39, 45},
    {15, 0, "rock", "platformer/tileBlue_08.png", 64, 64},
    {15, 1, "rock", "platformer/tileGreen_08.png", 64, 64},
    {15, 2, "rock", "platformer/tileYellow_09.png", 64, 64},
    {15, 3, "rock", "platformer/tileBrown_09.png", 64, 64},
    {16, 0, "platform", "platformer/tileBlue_05.png", 64, 64},
    {16, 1, "platform", "platformer/tileGreen_05.png", 64, 64},
    {16, 2, "platform", "platformer/tileYellow_06.png", 64, 64},
    {16, 3, "platform", "platformer/tileBrown_06.png", 64, 53},
};

constexpr int kBlockShapedKinds[] = {kRockKind, kPlatformKind};

constexpr GameArtSpec kArt = {.slots = kArtSlots,
                              .block_shaped_kinds = kBlockShapedKinds,
                              .background_group = BackgroundGroup::kPlatform};

bool IsGround(int kind) { return kind == kRockKind || kind == kPlatformKind; }

class Climber final : public Game {
 public:
  explicit Climber(const GameOptions& options) : Game(kArt, options) {
    top_speed_ = kTopSpeed;
    jump_speed_ = kJumpSpeed;
    world_.out_of_bounds_kind = kRockKind;
  }

 private:
  // --- Level generation: platforms from the floor upward, each beginning next to a column of the
  // one below.

  void MakeLevel() override {
    const bool is_easy = options().distribution_mode == DistributionMode::kEasy;
    const int width = is_easy ? kWorldWidthEasy : kWorldWidthHard;
    fish_chance_ = is_easy ? kFishChanceEasy : kFishChanceHard;
    cells_in_view_ = static_cast<float>(width);
    StandardReset(width, kWorldHeight);
    Entity& agent = world_.agent();
    agent.rx = kAgentRadius;
    agent.ry = kAgentRadius;
    agent.x = kAgentStart;
    agent.y = kAgentStart;
    has_support_ = false;
    agent.theme = DrawTheme(kAgentKind);
    const int wall_theme = random_.Int(kWallThemeCount);
    cell_looks_[kRockKind].theme = static_cast<int16_t>(wall_theme);
    cell_looks_[kPlatformKind].theme = static_cast<int16_t>(wall_theme);

    Grid& grid = world_.grid;
    grid.Fill(0, 0, width, 1, kPlatformKind);
    grid.Fill(0, 0, 1, kWorldHeight, kRockKind);
    grid.Fill(width - 1, 0, 1, kWorldHeight, kRockKind);
    grid.Fill(0, kWorldHeight - 1, width, 1, kRockKind);

    const int platform_count = DrawPlatformCount();
    crystals_left_ = 0;
    int column = random_.Int(width - 4) + 2;
    int row = 0;
    for (int i = 0; i < platform_count; ++i) {
      MakePlatform(&column, &row, i == platform_count - 1);
    }
  }

  int DrawPlatformCount() {
    switch (random_.Int(3)) {
      case 0:
        return 1 + random_.Int(2);
      case 1:
        return 2 + random_.Int(4);
      default:
        return 5 + random_.Int(6);
    }
  }

  // Makes a platform and its objects above the platform that contains the cell (column, row). Sets
  // (column, row) to a cell of the new platform.
  void MakePlatform(int* column, int* row, bool is_last) {
    const int width = world_.grid.width();
    const int rise = random_.Int(kRiseCount) + kRiseMin;
    if (*column >= kTurnMargin && *column <= width - kTurnMargin && random_.Unit() < fish_chance_) {
      AddFish(*column, *row);
    }
    *row += rise;
    const int length = random_.Int(kLengthCount) + kLengthMin;
    bool leads_right = random_.Int(2) == 1;
    if (*column < kTurnMargin) {
      leads_right = true;
    } else if (*column > width - kTurnMargin) {
      leads_right = false;
    }
    // The column in which the player comes up stays free.
    std::vector<int> columns;
    for (int i = 1; i <= length; ++i) {
      const int next = leads_right ? *column + i : *column - i;
      if (next <= 0 || next >= width - 1) {
        break;
      }
      world_.grid.Set(next, *row, kPlatformKind);
      columns.push_back(next);
    }
    const bool has_crystal = random_.Unit() < kCrystalChance;
    if (has_crystal || is_last) {
      AddCrystal(random_.OneOf(columns), *row + 1);
    }
    *column = random_.OneOf(columns);
  }

  // Adds a fish that swims back and forth above the platform that contains the cell (column, row).
  void AddFish(int column, int row) {
    const int direction = 2 * random_.Int(2) - 1;
    const int height = random_.Int(2) + 2;  // above the platform
    const float x = static_cast<float>(column) + 0.5F;
    const float y = static_cast<float>(row + height) + 0.5F;
    Entity& fish = world_.entities.emplace_back(
        Entity::Make(kFishKind, x, y, static_cast<float>(kFishSpeed * direction), 0, kFishRadius,
                     kFishRadius / AspectRatio(kFishImageKind, 0)));
    fish.image_kind = kFishImageKind;
    fish.smart = true;
    fish.patrol_center = x;
  }

  void AddCrystal(int column, int row) {
    SpawnAtCell(world_, kCrystalKind, kCrystalRadius, world_.grid.IndexOf(column, row));
    ++crystals_left_;
  }

  // --- Step.

  void PlayStep() override {
    StandardStep();
    if (world_.controls.horizontal != 0) {
      world_.agent().mirrored = world_.controls.horizontal < 0;
    }
    for (Entity& entity : world_.entities) {
      if (entity.kind == kFishKind) {
        Patrol(entity);
      }
    }
    if (crystals_left_ == 0) {
      outcome_.done = true;
      outcome_.reward += kCompletionReward;
      outcome_.level_complete = true;
    }
  }

  bool ShowsFirstFrame() const { return (step_number() / kFrameSteps) % 2 == 0; }

  void Patrol(Entity& fish) const {
    if (fish.x > fish.patrol_center + kPatrolReach) {
      fish.vx = -std::fabs(fish.vx);
    } else if (fish.x < fish.patrol_center - kPatrolReach) {
      fish.vx = std::fabs(fish.vx);
    }
    fish.image_kind = ShowsFirstFrame() ? kFishImageKind : kFishTailClosedImageKind;
    fish.mirrored = fish.vx < 0;
  }

  // Up jumps if the agent has support. Down has no effect.
  void MapControls() override {
    has_support_ = StandsOn(world_, world_.agent(), IsGround);
    if (world_.controls.vertical < 0 || !has_support_) {
      world_.controls.vertical = 0;
    }
  }

  void UpdateAgentVelocity() override {
    Entity& agent = world_.agent();
    const float mix = has_support_ ? kMix : kMix * kAirMixFactor;
    agent.vx = (1 - mix) * agent.vx + (mix * kTopSpeed) * world_.controls.horizontal;
    if (world_.controls.vertical > 0) {
      agent.vy = takeoff_speed_;
    }
    if (!has_support_ && agent.vy > -kFallSpeedMax) {
      agent.vy -= gravity_;
    }
  }

  // --- Contacts.

  bool Blocks(const Entity& mover, int kind, Axis axis) override {
    return (mover.kind == kAgentKind && kind == kPlatformKind) || Game::Blocks(mover, kind, axis);
  }

  // Rock both reflects and blocks a fish, so each bounce costs it some speed.
  bool Reflects(const Entity& mover, int kind) override {
    return mover.kind == kFishKind && IsGround(kind);
  }

  void OnAgentContact(Entity& other) override {
    if (other.kind == kFishKind) {
      outcome_.done = true;
    } else if (other.kind == kCrystalKind) {
      outcome_.reward += kCrystalReward;
      --crystals_left_;
      other.marked = true;
    }
  }

  // --- Appearance.

  // The view is as wide as the world and shows the part above the agent.
  Camera MakeCamera() const override {
    Camera camera = Game::MakeCamera();
    if (center_agent_) {
      const Entity& agent = world_.agent();
      camera.center_x = static_cast<float>(world_.grid.width()) / 2;
      camera.center_y = static_cast<float>((agent.y + world_.grid.width() / 2.0) -
                                           static_cast<double>(kViewFeetMargin * agent.ry));
    }
    return camera;
  }

  int ImageKindOf(const Entity& entity) const override {
    if (entity.kind != kAgentKind) {
      return Game::ImageKindOf(entity);
    }
    if (!has_support_) {
      return kPlayerJumpImageKind;
    }
    if (std::fabs(entity.vx) < kStandingSpeed && world_.controls.horizontal == 0) {
      return kAgentKind;
    }
    return ShowsFirstFrame() ? kPlayerWalkTogetherImageKind : kPlayerWalkApartImageKind;
  }

  void VisitOwnState(StateArchive& archive) override {
    archive.Int("crystals_left", crystals_left_, 0, world_.grid.size());
    archive.Bool("has_support", has_support_);
  }

  float fish_chance_ = 0;  // by mode
  int32_t crystals_left_ = 0;
  bool has_support_ = false;  // computed in MapControls of the last step
  const float gravity_ = ValueOf(Variant::kGravity, kGravity);
  const float takeoff_speed_ = ValueOf(Variant::kJumpSpeed, kJumpSpeed);
};

}  // namespace

extern constexpr GameSpec kClimber = {
    .name = "climber",
    .description = "A climber jumps from platform to platform and collects crystals.",
    .modes = kEasyHard,
    .easy_returns = {2, 12.6},
    .hard_returns = {1, 12.6},
    .exploration_level = 1561126160,
    .kinds = kKinds,
    .make = MakeGame<Climber>,
};

}  // namespace procgen
