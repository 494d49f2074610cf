// Ninja: a side-view platform game over a burning floor. The ninja walks and jumps over narrow
// platforms to the mushroom at the right (+10, level complete). Holding up charges a jump,
// releasing it jumps. Throwing stars destroy the bombs in the way. Bombs, explosions and fire end
// the episode.

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "envcore/games/game.h"
#include "envcore/games/game_spec.h"
#include "envcore/world/direction.h"
#include "envcore/world/placing.h"
#include "envcore/world/support.h"
#include "envcore/world/world_state.h"

namespace procgen {
namespace {

constexpr int kMushroomKind = 1;
constexpr int kBombKind = 6;
constexpr int kStarKind = 7;
constexpr int kNinjaWalkApartImageKind = 12;  // image kinds: poses
constexpr int kNinjaWalkTogetherImageKind = 13;
constexpr int kFireKind = 14;
constexpr int kBricksKind = 20;  // also everything outside the world

constexpr KindName kKinds[] = {{kMushroomKind, "mushroom", true},
                               {kBombKind, "bomb"},
                               {kStarKind, "star"},
                               {kFireKind, "fire"},
                               {kBricksKind, "bricks"}};

constexpr SpecialAction kSpecialActions[] = {
    {9, "Throws a star ahead, at most one star in 3 steps."},
    {10, "Throws a star ahead and up."},
    {11, "Throws a star up."},
    {12, "Throws a star ahead and down."},
    {13, "Throws a star ahead."},
    {14, "Throws a star ahead."}};

constexpr int kWorldSide = 64;        // cells
constexpr float kAgentRadius = 0.5F;  // cells
constexpr float kAgentStartX = 1.5F;
constexpr float kMushroomRadius = 0.5F;
constexpr float kExplosionRadius = 0.5F;  // initial value

constexpr float kMix = 0.5F;            // weight of the new velocity, with support
constexpr float kAirMixFactor = 0.15F;  // without support
constexpr float kTopSpeed = 0.5F;       // cells per step
constexpr float kGravity = 0.2F;        // cells per step, in each step without support
constexpr float kFallSpeedMax = 2;      // gravity adds nothing beyond this
constexpr float kMushroomReward = 10;
constexpr int kFrameSteps = 5;           // steps per frame of a walk
constexpr double kStandingSpeed = 0.01;  // slower counts as standing

// The directions of the stars of the special actions, facing right; radians upward.
constexpr float kStarAngles[] = {0, kPi / 4, kHalfPi, -kPi / 4, 0, 0};
constexpr float kStarRadius = 0.25F;  // cells
constexpr int kStarLifeSteps = 15;
constexpr int kStarPauseSteps = 3;  // least steps from one star to the next

constexpr int kStartColumns = 5;  // ground that the agent starts on
constexpr int kStartHeight = 32;  // heights: the first free row above a platform
constexpr int kStartHeadroom = 8;
constexpr int kSectionColumnsMax = 15;  // no platform begins closer to the right end
constexpr int kPlatformsMax = 2;        // per section
constexpr int kHighHeight = 49;         // platforms go down from this height
constexpr int kMiddleHeight = 5;        // platforms may go down from this height
constexpr double kDownChance = 0.4;
constexpr int kHeightMin = 3;
constexpr int kLengthCount = 3;   // number of different lengths of platforms
constexpr int kBombHeadroom = 2;  // from the highest height of a section to the row of its bomb
constexpr int kCeilingHeadroom = 10;
constexpr int kMushroomHeadroom = 6;
constexpr int kFireDepth = 2;  // below the lowest height
constexpr int kBricksThemeCount = 3;

constexpr float kChargeBarLeft = 0.25F;  // cells
constexpr float kChargeBarWidth = 0.5F;
constexpr float kChargeBarHeight = 3;     // fully charged
constexpr double kChargeBarMargin = 0.5;  // from the lower edge of the image
constexpr std::array<uint8_t, 3> kChargeBarColor = {66, 245, 135};

// Set by the level's difficulty (1 to 3, index 0 to 2), besides the mode.
constexpr int kExtraGapCounts[] = {2, 3, 3};        // number of different gaps
constexpr float kBombChances[] = {0, 0.25F, 0.5F};  // per section

struct ModeFigures {
  float jump_speed;   // of a full charge, cells per step
  float charge_rate;  // fraction per step
  float cells_in_view;
  int length_min;   // of platforms, cells
  int gap_mins[3];  // between platforms, cells, by difficulty
  int rise_count;   // number of different rises from one platform to the next
};

constexpr ModeFigures kEasyFigures = {.jump_speed = 1.25F,
                                      .charge_rate = 1,
                                      .cells_in_view = 10,
                                      .length_min = 3,
                                      .gap_mins = {0, 0, 1},
                                      .rise_count = 2};
constexpr ModeFigures kHardFigures = {.jump_speed = 1.5F,
                                      .charge_rate = 0.25F,
                                      .cells_in_view = 16,
                                      .length_min = 1,
                                      .gap_mins = {0, 1, 2},
                                      .rise_count = 4};

constexpr ArtSlot kArtSlots[] = {
    {0, 0, "ninja_stand", "platformer/zombie_idle.png", 80, 110},
    {1, 0, "mushroom", "platformer/shroom1.png", 70, 70},
    {1, 1, "mushroom", "platformer/shroom2.png", 70, 70},
    {1, 2, "mushroom", "platformer/shroom3.png", 70, 70},
    {1, 3, "mushroom", "platformer/shroom4.png", 70, 70},
    {1, 4, "mushroom", "platformer/shroom5.png", 70, 70},
    {1, 5, "mushroom", "platformer/shroom6.png", 70, 70},
    {6, 0, "bomb", "misc_assets/bomb.png", 128, 128},
    {7, 0, "star", "misc_assets/saw.png", 128, 128},
    {9, 0, "ninja_jump", "platformer/zombie_jump.png", 80, 110},
    {12, 0, "ninja_walk_apart", "platformer/zombie_walk1.png", 80, 110},
    {13, 0, "ninja_walk_together", "platformer/zombie_walk2.png", 80, 110},
    {14, 0, "fire", "misc_assets/bomb.png", 128, 128},
    {20, 0, "bricks", "misc_assets/tile_bricksGrey.png", 64, 64},
    {20, 1, "bricks", "misc_assets/tile_bricksGrown.png", 64, 64},
    {20, 2, "bricks", "misc_assets/tile_bricksRed.png", 64, 64},
};

constexpr int kBlockShapedKinds[] = {kBricksKind};

constexpr GameArtSpec kArt = {.slots = kArtSlots,
                              .block_shaped_kinds = kBlockShapedKinds,
                              .background_group = BackgroundGroup::kPlatform};

bool IsGround(int kind) { return kind == kBricksKind; }

class Ninja final : public Game {
 public:
  explicit Ninja(const GameOptions& options)
      : Game(kArt, options),
        figures_(options.distribution_mode == DistributionMode::kEasy ? kEasyFigures
                                                                      : kHardFigures) {
    cells_in_view_ = figures_.cells_in_view;
    top_speed_ = kTopSpeed;
    jump_speed_ = figures_.jump_speed;
    world_.out_of_bounds_kind = kBricksKind;
  }

 private:
  // --- Level generation: sections of platforms from left to right, then the mushroom, then fire
  // below everything.

  void MakeLevel() override {
    StandardReset(kWorldSide, kWorldSide);
    Entity& agent = world_.agent();
    agent.rx = kAgentRadius;
    agent.ry = kAgentRadius;
    agent.x = kAgentStartX;
    agent.y = kStartHeight + kAgentRadius;
    charge_ = 0;
    has_support_ = false;
    last_star_step_ = 0;
    difficulty_ = random_.Int(3) + 1;
    cell_looks_[kBricksKind].theme = static_cast<int16_t>(random_.Int(kBricksThemeCount));

    Grid& grid = world_.grid;
    grid.Fill(0, 0, kWorldSide, 1, kBricksKind);
    grid.Fill(0, 0, 1, kWorldSide, kBricksKind);
    grid.Fill(kWorldSide - 1, 0, 1, kWorldSide, kBricksKind);
    grid.Fill(0, kWorldSide - 1, kWorldSide, 1, kBricksKind);
    const int section_count = random_.Int(difficulty_) + difficulty_;
    grid.Fill(0, 0, kStartColumns, kStartHeight, kBricksKind);
    FillToTop(0, kStartColumns, kStartHeight + kStartHeadroom);

    int column = kStartColumns;
    int height = kStartHeight;
    lowest_height_ = kStartHeight;
    for (int i = 0; i < section_count; ++i) {
      MakeSection(&column, &height);
    }
    MakeEnd(column, height);
  }

  void FillToTop(int column, int width, int row) {
    world_.grid.Fill(column, row, width, kWorldSide - row, kBricksKind);
  }

  // Makes one or two platforms from `column` on, a bomb above them and a ceiling. Sets `column` and
  // `height` to their end. The platforms are not consecutive: both begin near the beginning of the
  // section, above or below its height. Too close to the right end none is made.
  void MakeSection(int* column, int* height) {
    const int first_column = *column;
    const int first_height = *height;
    const int platform_count = random_.Int(kPlatformsMax) + 1;
    int highest = -1;
    int last_height = -1;
    for (int i = 0; i < platform_count; ++i) {
      *column = first_column + i;
      if (*column + kSectionColumnsMax >= kWorldSide) {
        break;
      }
      *height = DrawHeight(first_height);
      if (std::abs(*height - last_height) <= 1) {
        *height = last_height + 2;
      }
      const int length = random_.Int(kLengthCount) + figures_.length_min;
      world_.grid.Fill(*column, *height - 1, length, 1, kBricksKind);
      *column += length + figures_.gap_mins[difficulty_ - 1];
      *column += random_.Int(kExtraGapCounts[difficulty_ - 1]);
      highest = std::max(highest, *height);
      lowest_height_ = std::min(lowest_height_, *height);
      last_height = *height;
    }
    if (random_.Unit() < kBombChances[difficulty_ - 1]) {
      const int offset = random_.Int(*column - first_column + 1);
      world_.grid.Set(first_column + offset, highest + kBombHeadroom, kBombKind);
    }
    FillToTop(first_column, *column - first_column, highest + kCeilingHeadroom);
  }

  // The height of the platform after one of `height`.
  int DrawHeight(int height) {
    int rise = random_.Int(figures_.rise_count) + 1 + difficulty_ / 3;
    if (height >= kHighHeight) {
      rise = -rise;
    } else if (height >= kMiddleHeight) {
      const double share = random_.Unit();
      if (share < kDownChance) {
        rise = -rise;
      }
    }
    return std::max(kHeightMin, height + rise);
  }

  // The mushroom on a platform of its own, solid bricks behind it, and fire below all platforms.
  void MakeEnd(int column, int height) {
    Grid& grid = world_.grid;
    Entity& mushroom =
        SpawnAtCell(world_, kMushroomKind, kMushroomRadius, grid.IndexOf(column, height));
    mushroom.theme = DrawTheme(kMushroomKind);
    grid.Set(column, height - 1, kBricksKind);
    FillToTop(column, 1, height + kMushroomHeadroom);
    const int fire_row = std::max(1, lowest_height_ - kFireDepth);
    grid.Fill(kStartColumns, 0, kWorldSide - kStartColumns, fire_row, kBricksKind);
    grid.Fill(kStartColumns, fire_row, kWorldSide - kStartColumns, 1, kFireKind);
    FillToTop(column + 1, kWorldSide - 1 - column, 0);
  }

  // --- Step.

  void PlayStep() override {
    StandardStep();
    if (world_.controls.horizontal != 0) {
      world_.agent().mirrored = world_.controls.horizontal < 0;
    }
    if (special_action_ > 0 && step_number() - last_star_step_ >= kStarPauseSteps) {
      ThrowStar(kStarAngles[special_action_ - 1]);
      last_star_step_ = step_number();
    }
  }

  void ThrowStar(float angle) {
    if (world_.agent().mirrored) {
      angle = kPi - angle;
    }
    Entity& star = SpawnChild(world_, kStarKind, kStarRadius, world_.agent(), false);
    star.vx = static_cast<float>(std::cos(static_cast<double>(angle)));
    star.vy = static_cast<float>(std::sin(static_cast<double>(angle)));
    star.expiry = kStarLifeSteps;
    star.smart = true;
  }

  // Holding up charges a jump while the ninja stands on something.
  void MapControls() override {
    has_support_ = StandsOn(world_, world_.agent(), IsGround);
    const bool charges = has_support_ && world_.controls.vertical > 0;
    world_.controls.vertical = charges ? 1 : 0;
    if (charges) {
      charge_ = std::min(1.0F, charge_ + figures_.charge_rate);
    } else if (!has_support_) {
      charge_ = 0;
    }
  }

  void UpdateAgentVelocity() override {
    Entity& agent = world_.agent();
    const float mix = has_support_ ? kMix : kMix * kAirMixFactor;
    agent.vx = (1 - mix) * agent.vx + (mix * kTopSpeed) * world_.controls.horizontal;
    const bool lets_go = world_.controls.vertical < 1 && charge_ > 0;
    if (lets_go) {
      agent.vy = charge_ * figures_.jump_speed;
      charge_ = 0;
    }
    if (!has_support_ && agent.vy > -kFallSpeedMax) {
      agent.vy -= gravity_;
    }
  }

  // --- Contacts.

  // A star sticks to the bricks that stop it until it expires.
  void OnStoppedByCell(Entity& mover, Axis /*axis*/) override {
    if (mover.kind == kStarKind) {
      mover.vx = 0;
      mover.vy = 0;
    }
  }

  void OnAgentContact(Entity& other) override {
    if (other.kind == kExplosionKind) {
      outcome_.done = true;
    } else if (other.kind == kMushroomKind) {
      outcome_.reward += kMushroomReward;
      outcome_.level_complete = true;
      outcome_.done = true;
    }
  }

  void OnCellContact(Entity& entity, int kind, int x, int y) override {
    if (entity.kind == kAgentKind) {
      if (kind == kFireKind || kind == kBombKind) {
        outcome_.done = true;
      }
    } else if (kind == kBombKind) {
      entity.marked = true;
      world_.grid.Set(x, y, kEmptyKind);
      SpawnAtCell(world_, kExplosionKind, kExplosionRadius, world_.grid.IndexOf(x, y));
    } else if (kind == kBricksKind) {
      entity.marked = true;
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
    return (step_number() / kFrameSteps) % 2 == 0 || !has_support_ ? kNinjaWalkApartImageKind
                                                                   : kNinjaWalkTogetherImageKind;
  }

  // The charge bar grows upward from the lower left corner.
  void AddOverlays(std::vector<Overlay>* overlays) const override {
    const float height = kChargeBarHeight * charge_;
    const auto top = static_cast<float>((MakeCamera().cells - kChargeBarMargin) - height);
    overlays->push_back({.shape = Overlay::Shape::kRectangle,
                         .x = kChargeBarLeft,
                         .y = top,
                         .width = kChargeBarWidth,
                         .height = height,
                         .color = kChargeBarColor});
  }

  void VisitOwnState(StateArchive& archive) override {
    archive.Float("charge", charge_, 0, 1);
    archive.Bool("has_support", has_support_);
    archive.Int("last_star_step", last_star_step_, -kRememberedStepMax, kRememberedStepMax);
  }

  const ModeFigures& figures_;
  int difficulty_ = 1;        // 1 to 3, drawn for each level
  int lowest_height_ = 0;     // of the level's platforms
  float charge_ = 0;          // of the jump, in [0, 1]
  bool has_support_ = false;  // computed in MapControls of the last step
  int32_t last_star_step_ = 0;
  const float gravity_ = ValueOf(Variant::kGravity, kGravity);
};

}  // namespace

extern constexpr GameSpec kNinja = {
    .name = "ninja",
    .description =
        "A ninja jumps over ledges and throws stars at bombs on the way to the mushroom.",
    .modes = kEasyHard,
    .easy_returns = {3.5, 10},
    .hard_returns = {2, 10},
    .exploration_level = 1123500215,
    .special_actions = kSpecialActions,
    .kinds = kKinds,
    .make = MakeGame<Ninja>,
};

}  // namespace procgen
