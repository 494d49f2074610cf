// CoinRun: a side-view platform game. The player starts at the left and reaches the coin at the far
// right (+10, level complete). On the way it jumps over steps, pits, saws, walking enemies and
// crates. Saws, walkers and lava end the episode.

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "envcore/games/game.h"
#include "envcore/games/game_spec.h"
#include "envcore/world/placing.h"
#include "envcore/world/support.h"
#include "envcore/world/world_state.h"

namespace procgen {
namespace {

constexpr int kCoinKind = 1;
constexpr int kSawKind = 2;
constexpr int kSawTurnedKind = 3;  // image kinds: second frames, poses
constexpr int kWalkerKind = 5;
constexpr int kWalkerImageKind = 6;
constexpr int kWalkerStepImageKind = 7;
constexpr int kPlayerJumpImageKind = 9;
constexpr int kPlayerWalkApartImageKind = 12;
constexpr int kPlayerWalkTogetherImageKind = 13;
constexpr int kGroundKind = 15;  // also everything outside the world
constexpr int kGroundTopKind = 16;
constexpr int kLavaKind = 17;
constexpr int kLavaSurfaceKind = 18;
constexpr int kBarrierKind = 19;  // invisible; walkers turn around at it
constexpr int kCrateKind = 20;

constexpr KindName kKinds[] = {{kCoinKind, "coin", true},
                               {kSawKind, "saw"},
                               {kWalkerKind, "walker"},
                               {kGroundKind, "ground"},
                               {kGroundTopKind, "ground_top"},
                               {kLavaKind, "lava"},
                               {kLavaSurfaceKind, "lava_surface"},
                               {kBarrierKind, "barrier"},
                               {kCrateKind, "crate"}};

// Limits in a snapshot. Levels stay below them, except with two piles in one column.
constexpr size_t kEntitiesMax = 384;
constexpr int kMoversMax = 40;           // agent included
constexpr float kWalkerSpeedMax = 0.5F;  // cells per step
constexpr size_t kCrateCellsMax = 64;
constexpr int kCratesInCellMax = 2;
constexpr int kWorldSide = 64;  // cells
constexpr float kCellsInView = 13;
constexpr float kAgentRadiusX = 0.5F;  // cells
constexpr float kAgentRadiusY = 0.5787F;
constexpr float kAgentStartX = 1.5F;
constexpr float kRadius = 0.5F;  // of saws, walkers and crates

constexpr float kMix = 0.2F;            // weight of the new velocity, with support
constexpr float kAirMixFactor = 0.15F;  // without support
constexpr float kTopSpeed = 0.5F;       // cells per step
constexpr float kJumpSpeed = 1.5F;      // also the limit of the vertical speed
constexpr float kGravity = 0.2F;        // cells per step, in each step
constexpr double kDuckShare = 0.2;      // of the vertical control, with support
constexpr double kWalkerSpeed = 0.15;
constexpr float kCoinReward = 10;
constexpr int kFrameSteps = 5;           // steps per frame of a walk
constexpr double kStandingSpeed = 0.01;  // slower counts as standing

constexpr int kStartColumn = 5;
constexpr int kSectionColumnsMax = 15;  // no section begins closer to the right end
constexpr int kHighGround = 20;         // sections go down from this height
constexpr int kMiddleGround = 5;        // sections may go down from this height
constexpr int kGroundThemeCount = 6;

constexpr int kNoPitsBit = 2;  // of debug_mode
constexpr int kNoCratesBit = 4;
constexpr int kFlatBit = 8;

enum class PitDanger { kLava = 0, kSaws = 1, kWalkers = 2 };

constexpr ArtSlot kArtSlots[] = {
    {0, 0, "player_stand", "kenney/Players/128x256/Beige/alienBeige_stand.png", 128, 256},
    {0, 1, "player_stand", "kenney/Players/128x256/Blue/alienBlue_stand.png", 128, 256},
    {0, 2, "player_stand", "kenney/Players/128x256/Green/alienGreen_stand.png", 128, 256},
    {0, 3, "player_stand", "kenney/Players/128x256/Pink/alienPink_stand.png", 128, 256},
    {0, 4, "player_stand", "kenney/Players/128x256/Yellow/alienYellow_stand.png", 128, 256},
    {1, 0, "coin", "kenney/Items/coinGold.png", 128, 128},
    {2, 0, "saw", "kenney/Enemies/sawHalf.png", 128, 128},
    {3, 0, "saw_turned", "kenney/Enemies/sawHalf_move.png", 128, 128},
    {6, 0, "walker", "kenney/Enemies/slimeBlock.png", 128, 128},
    {6, 1, "walker", "kenney/Enemies/slimePurple.png", 128, 128},
    {6, 2, "walker", "kenney/Enemies/slimeBlue.png", 128, 128},
    {6, 3, "walker", "kenney/Enemies/slimeGreen.png", 128, 128},
    {6, 4, "walker", "kenney/Enemies/mouse.png", 128, 128},
    {6, 5, "walker", "kenney/Enemies/snail.png", 128, 128},
    {6, 6, "walker", "kenney/Enemies/ladybug.png", 128, 128},
    {6, 7, "walker", "kenney/Enemies/wormGreen.png", 128, 128},
    {6, 8, "walker", "kenney/Enemies/wormPink.png", 128, 128},
    {7, 0, "walker_step", "kenney/Enemies/slimeBlock_move.png", 128, 128},
    {7, 1, "walker_step", "kenney/Enemies/slimePurple_move.png", 128, 128},
    {7, 2, "walker_step", "kenney/Enemies/slimeBlue_move.png", 128, 128},
    {7, 3, "walker_step", "kenney/Enemies/slimeGreen_move.png", 128, 128},
    {7, 4, "walker_step", "kenney/Enemies/mouse_move.png", 128, 128},
    {7, 5, "walker_step", "kenney/Enemies/snail_move.png", 128, 128},
    {7, 6, "walker_step", "kenney/Enemies/ladybug_move.png", 128, 128},
    {7, 7, "walker_step", "kenney/Enemies/wormGreen_move.png", 128, 128},
    {7, 8, "walker_step", "kenney/Enemies/wormPink_move.png", 128, 128},
    {9, 0, "player_jump", "kenney/Players/128x256/Beige/alienBeige_jump.png", 128, 256},
    {9, 1, "player_jump", "kenney/Players/128x256/Blue/alienBlue_jump.png", 128, 256},
    {9, 2, "player_jump", "kenney/Players/128x256/Green/alienGreen_jump.png", 128, 256},
    {9, 3, "player_jump", "kenney/Players/128x256/Pink/alienPink_jump.png", 128, 256},
    {9, 4, "player_jump", "kenney/Players/128x256/Yellow/alienYellow_jump.png", 128, 256},
    {12, 0, "player_walk_apart", "kenney/Players/128x256/Beige/alienBeige_walk1.png", 128, 256},
    {12, 1, "player_walk_apart", "kenney/Players/128x256/Blue/alienBlue_walk1.png", 128, 256},
    {12, 2, "player_walk_apart", "kenney/Players/128x256/Green/alienGreen_walk1.png", 128, 256},
    {12, 3, "player_walk_apart", "kenney/Players/128x256/Pink/alienPink_walk1.png", 128, 256},
    {12, 4, "player_walk_apart", "kenney/Players/128x256/Yellow/alienYellow_walk1.png", 128, 256},
    {13, 0, "player_walk_together", "kenney/Players/128x256/Beige/alienBeige_walk2.png", 128, 256},
    {13, 1, "player_walk_together", "kenney/Players/128x256/Blue/alienBlue_walk2.png", 128, 256},
    {13, 2, "player_walk_together", "kenney/Players/128x256/Green/alienGreen_walk2.png", 128, 256},
    {13, 3, "player_walk_together", "kenney/Players/128x256/Pink/alienPink_walk2.png", 128, 256},
    {13, 4, "player_walk_together", "kenney/Players/128x256/Yellow/alienYellow_walk2.png", 128,
     256},
    {15, 0, "ground", "kenney/Ground/Dirt/dirtCenter.png", 128, 128},
    {15, 1, "ground", "kenney/Ground/Grass/grassCenter.png", 128, 128},
    {15, 2, "ground", "kenney/Ground/Planet/planetCenter.png", 128, 128},
    {15, 3, "ground", "kenney/Ground/Sand/sandCenter.png", 128, 128},
    {15, 4, "ground", "kenney/Ground/Snow/snowCenter.png", 128, 128},
    {15, 5, "ground", "kenney/Ground/Stone/stoneCenter.png", 128, 128},
    {16, 0, "ground_top", "kenney/Ground/Dirt/dirtMid.png", 128, 128},
    {16, 1, "ground_top", "kenney/Ground/Grass/grassMid.png", 128, 128},
    {16, 2, "ground_top", "kenney/Ground/Planet/planetMid.png", 128, 128},
    {16, 3, "ground_top", "kenney/Ground/Sand/sandMid.png", 128, 128},
    {16, 4, "ground_top", "kenney/Ground/Snow/snowMid.png", 128, 128},
    {16, 5, "ground_top", "kenney/Ground/Stone/stoneMid.png", 128, 128},
    {17, 0, "lava", "kenney/Tiles/lava.png", 128, 128},
    {18, 0, "lava_surface", "kenney/Tiles/lavaTop_low.png", 128, 128},
    {20, 0, "crate", "kenney/Tiles/boxCrate.png", 128, 128},
    {20, 1, "crate", "kenney/Tiles/boxCrate_double.png", 128, 128},
    {20, 2, "crate", "kenney/Tiles/boxCrate_single.png", 128, 128},
    {20, 3, "crate", "kenney/Tiles/boxCrate_warning.png", 128, 128},
};

constexpr int kBlockShapedKinds[] = {kGroundKind, kGroundTopKind};

constexpr GameArtSpec kArt = {.slots = kArtSlots,
                              .block_shaped_kinds = kBlockShapedKinds,
                              .background_group = BackgroundGroup::kPlatform};

bool IsGround(int kind) { return kind == kGroundKind || kind == kGroundTopKind; }

bool IsPlayerImage(int image_kind) {
  return image_kind == kAgentKind || image_kind == kPlayerJumpImageKind ||
         image_kind == kPlayerWalkApartImageKind || image_kind == kPlayerWalkTogetherImageKind;
}

class CoinRun final : public Game {
 public:
  explicit CoinRun(const GameOptions& options) : Game(kArt, options) {
    cells_in_view_ = kCellsInView;
    top_speed_ = kTopSpeed;
    jump_speed_ = kJumpSpeed;
    world_.out_of_bounds_kind = kGroundKind;
  }

 private:
  // --- Level generation: sections of ground and pits from left to right, then the coin.

  void MakeLevel() override {
    StandardReset(kWorldSide, kWorldSide);
    Entity& agent = world_.agent();
    ground_theme_ = 0;
    if (IsEasy()) {
      background_index_ = 0;
    } else {
      agent.theme = DrawTheme(kAgentKind);
      ground_theme_ = random_.Int(kGroundThemeCount);
    }
    cell_looks_[kGroundKind].theme = static_cast<int16_t>(ground_theme_);
    cell_looks_[kGroundTopKind].theme = static_cast<int16_t>(ground_theme_);
    cell_looks_[kBarrierKind].image_kind = -1;
    agent.rx = kAgentRadiusX;
    agent.ry = kAgentRadiusY;
    agent.x = kAgentStartX;
    agent.y = 1 + kAgentRadiusY;
    has_support_ = false;
    on_crate_ = false;
    remembered_y_ = agent.y;

    Grid& grid = world_.grid;
    grid.Fill(0, 0, kWorldSide, 1, kGroundTopKind);
    grid.Fill(0, 0, 1, kWorldSide, kGroundKind);
    grid.Fill(kWorldSide - 1, 0, 1, kWorldSide, kGroundKind);
    grid.Fill(0, kWorldSide - 1, kWorldSide, 1, kGroundKind);

    difficulty_ = random_.Int(3) + 1;
    const int section_count = random_.Int(difficulty_) + difficulty_;
    pit_danger_ = static_cast<PitDanger>(random_.Int(3));
    int column = kStartColumn;
    int height = 1;  // of the ground: the first free row
    for (int i = 0; i < section_count && column + kSectionColumnsMax < kWorldSide; ++i) {
      MakeSection(&column, &height);
    }
    grid.Set(column, height, kCoinKind);
    FillGround(column, 1, height);
    grid.Fill(column + 1, 0, kWorldSide - 1 - column, kWorldSide, kGroundKind);
  }

  bool IsEasy() const { return options().distribution_mode == DistributionMode::kEasy; }
  bool HasDebugBit(int bit) const { return (options().debug_mode & bit) != 0; }
  // The hardest levels have higher steps and longer sections.
  int HardestBonus() const { return difficulty_ / 3; }

  void FillGround(int column, int width, int height) {
    world_.grid.Fill(column, 0, width, height - 1, kGroundKind);
    world_.grid.Fill(column, height - 1, width, 1, kGroundTopKind);
  }

  void MakeSection(int* column, int* height) {
    int rise = random_.Int(4) + 1 + HardestBonus();
    if (HasDebugBit(kFlatBit)) {
      rise = 0;
    }
    if (*height >= kHighGround || (*height >= kMiddleGround && random_.Int(2) == 1)) {
      rise = -rise;
    }
    const int width = random_.Int(2 * difficulty_) + 3 + HardestBonus();
    *height = std::max(1, *height + rise);
    bool is_pit = false;
    if (!HasDebugBit(kNoPitsBit) && width > 7 && *height > 3) {
      is_pit = random_.Int(20) >= difficulty_;
    }
    if (is_pit) {
      MakePit(*column, width, *height);
    } else {
      MakeGround(*column, width, *height);
    }
    if (!IsGround(world_.grid.At(*column - 1, *height))) {
      world_.grid.Set(*column - 1, *height, kBarrierKind);
    }
    *column += width;
    world_.grid.Set(*column, *height, kBarrierKind);
  }

  void MakePit(int column, int width, int height) {
    const int left_rim = random_.Int(3) + 1;
    const int right_rim = random_.Int(3) + 1;
    const int pit_width = width - left_rim - right_rim;
    const int pit_column = column + left_rim;
    FillGround(column, left_rim, height);
    FillGround(column + width - right_rim, right_rim, height);
    const int lava_height = random_.Int(height - 3) + 1;
    switch (pit_danger_) {
      case PitDanger::kLava:
        world_.grid.Fill(pit_column, 1, pit_width, lava_height - 1, kLavaKind);
        world_.grid.Fill(pit_column, lava_height, pit_width, 1, kLavaSurfaceKind);
        break;
      case PitDanger::kSaws:
        for (int i = 0; i < pit_width; ++i) {
          AddAt(kSawKind, pit_column + i, 1);
        }
        break;
      case PitDanger::kWalkers:
        for (int i = 0; i < pit_width; ++i) {
          AddWalker(pit_column + i, 1);
        }
        break;
    }
    if (pit_width > 4) {
      MakeSteppingStone(pit_column, pit_width, height - 1);
    }
  }

  void MakeSteppingStone(int pit_column, int pit_width, int row) {
    const int offset = (pit_width > 5 ? 2 : 1) + random_.Int(2);
    const int drawn = random_.Int(2);  // for the width of a short stone, or the gap at its right
    const int width = pit_width > 6 ? pit_width - offset - (2 + drawn) : 1 + drawn;
    world_.grid.Fill(pit_column + offset, row, width, 1, kGroundTopKind);
  }

  void MakeGround(int column, int width, int height) {
    FillGround(column, width, height);
    int saw_column = -1;
    int walker_column = -1;
    if (random_.Int(10) < 2 * difficulty_ && width > 3) {
      saw_column = column + random_.Int(width - 2) + 1;
      AddAt(kSawKind, saw_column, height);
    }
    if (random_.Int(10) < difficulty_ && width > 3 && !IsEasy()) {
      walker_column = column + random_.Int(width - 2) + 1;
      AddWalker(walker_column, height);
    }
    if (HasDebugBit(kNoCratesBit)) {
      return;
    }
    for (int pile = 0; pile < 2; ++pile) {
      const int pile_column = column + random_.Int(width - 2) + 1;
      const bool wanted = random_.Int(2) == 1;
      if (wanted && pile_column != saw_column && pile_column != walker_column) {
        const int pile_height = random_.Int(3) + 1;
        for (int i = 0; i < pile_height; ++i) {
          AddAt(kCrateKind, pile_column, height + i).theme = DrawTheme(kCrateKind);
        }
      }
    }
  }

  Entity& AddAt(int kind, int column, int row) {
    return world_.entities.emplace_back(Entity::Make(kind, static_cast<float>(column) + 0.5F,
                                                     static_cast<float>(row) + 0.5F, 0, 0, kRadius,
                                                     kRadius));
  }

  void AddWalker(int column, int row) {
    Entity& walker = AddAt(kWalkerKind, column, row);
    walker.vx = static_cast<float>(kWalkerSpeed * (2 * random_.Int(2) - 1));
    walker.smart = true;
    walker.image_kind = kWalkerImageKind;
    walker.layer = 1;
    walker.theme = DrawTheme(kWalkerImageKind);
  }

  // --- Step.

  void PlayStep() override {
    StandardStep();
    Entity& agent = world_.agent();
    if (world_.controls.horizontal != 0) {
      agent.mirrored = world_.controls.horizontal < 0;
    }
    for (size_t i = world_.entities.size(); i-- > 0;) {
      if (world_.entities[i].kind == kWalkerKind) {
        AnimateWalker(i);
      } else if (world_.entities[i].kind == kSawKind) {
        world_.entities[i].image_kind = step_number() % 2 == 0 ? kSawKind : kSawTurnedKind;
      }
    }
    remembered_y_ = world_.agent().y;
  }

  // Walkers raise dust.
  void AnimateWalker(size_t index) {
    Entity& walker = world_.entities[index];
    walker.image_kind =
        (step_number() / kFrameSteps) % 2 == 0 ? kWalkerImageKind : kWalkerStepImageKind;
    walker.mirrored = walker.vx > 0;
    SpawnDust(world_, walker);
  }

  void MapControls() override {
    const Entity& agent = world_.agent();
    has_support_ = (on_crate_ || StandsOn(world_, agent, IsGround)) && agent.vy == 0;
    on_crate_ = false;
    if (world_.controls.vertical > 0 && !has_support_) {
      world_.controls.vertical = 0;
    }
  }

  void UpdateAgentVelocity() override {
    Entity& agent = world_.agent();
    const float mix = has_support_ ? kMix : kMix * kAirMixFactor;
    agent.vx = (1 - mix) * agent.vx + (mix * kTopSpeed) * world_.controls.horizontal;
    if (std::fabs(agent.vx) < mix * kTopSpeed) {
      agent.vx = 0;
    }
    if (world_.controls.vertical > 0) {
      agent.vy = takeoff_speed_;
      return;
    }
    if (has_support_) {
      agent.vy = static_cast<float>(agent.vy + kDuckShare * world_.controls.vertical);
    }
    agent.vy = std::clamp(agent.vy - gravity_, -takeoff_speed_, takeoff_speed_);
  }

  // --- Contacts.

  bool Blocks(const Entity& mover, int kind, Axis axis) override {
    return (mover.kind == kAgentKind && kind == kGroundTopKind) || Game::Blocks(mover, kind, axis);
  }

  bool Reflects(const Entity& mover, int kind) override {
    return mover.kind == kWalkerKind && (IsGround(kind) || kind == kBarrierKind);
  }

  // A crate carries the agent if it comes down on the crate from above without pressing down. The
  // conditions test the agent for any mover, so a walker inside a crate can set the flag.
  bool EntityBlocks(const Entity& mover, const Entity& other, Axis axis) override {
    if (other.kind != kCrateKind) {
      return Game::EntityBlocks(mover, other, axis);
    }
    const Entity& agent = world_.agent();
    const bool carries = axis == Axis::kVertical && agent.vy < 0 && world_.controls.vertical >= 0 &&
                         remembered_y_ >= (other.y + other.ry) + agent.ry;
    on_crate_ = on_crate_ || carries;
    return carries;
  }

  void OnCellContact(Entity& entity, int kind, int /*x*/, int /*y*/) override {
    if (entity.kind != kAgentKind) {
      return;
    }
    if (kind == kCoinKind) {
      outcome_.reward += kCoinReward;
      outcome_.done = true;
      outcome_.level_complete = true;
    } else if (kind == kLavaKind || kind == kLavaSurfaceKind) {
      outcome_.done = true;
    }
  }

  void OnAgentContact(Entity& other) override {
    if (other.kind == kSawKind || other.kind == kWalkerKind) {
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
    return (step_number() / kFrameSteps) % 2 == 0 || !has_support_ ? kPlayerWalkApartImageKind
                                                                   : kPlayerWalkTogetherImageKind;
  }

  // The player's image is twice as high as wide: the feet are at the bottom of the box, the head
  // extends above it.
  void StyleSprite(const Entity& /*entity*/, Sprite* sprite) const override {
    if (IsPlayerImage(sprite->image_kind)) {
      sprite->art_top = -0.7415;
      sprite->art_height = 1.7415;
    }
  }

  // Movers in crates are pushed between them, in each sub-step and again from each position that
  // they are pushed to. Returns whether this is limited enough for a step to be fast.
  bool PushesEndSoon() const {
    std::map<std::pair<float, float>, int> crate_counts;  // by place
    int mover_count = 0;
    for (const Entity& entity : world_.entities) {
      if (entity.kind == kCrateKind) {
        const bool rests = entity.vx == 0 && entity.vy == 0 && entity.growth <= 1 && !entity.smart;
        const bool fills_cell = entity.x - std::floor(entity.x) == kRadius &&
                                entity.y - std::floor(entity.y) == kRadius &&
                                std::max(entity.rx, entity.ry) <= kRadius;
        if (!rests || !fills_cell || ++crate_counts[{entity.x, entity.y}] > kCratesInCellMax) {
          return false;
        }
      } else if (entity.smart) {
        const float speed = std::max(std::fabs(entity.vx), std::fabs(entity.vy));
        if (entity.rx > kAgentRadiusX || entity.ry > kAgentRadiusY || ++mover_count > kMoversMax ||
            (&entity != &world_.agent() && speed > kWalkerSpeedMax)) {
          return false;
        }
      }
    }
    return crate_counts.size() <= kCrateCellsMax;
  }

  size_t EntityCountMax() const override { return kEntitiesMax; }
  void VisitOwnState(StateArchive& archive) override {
    archive.Bool("has_support", has_support_);
    archive.Bool("on_crate", on_crate_);
    archive.Float("remembered_y", remembered_y_, -kPlaceMax, kPlaceMax);
    archive.Check(!archive.restores() || PushesEndSoon(),
                  "has more or other crates and walkers than levels can have");
  }

  int difficulty_ = 1;  // 1 to 3, drawn for each level
  PitDanger pit_danger_ = PitDanger::kLava;
  int32_t ground_theme_ = 0;
  bool has_support_ = false;  // computed in MapControls of the last step
  bool on_crate_ = false;
  float remembered_y_ = 0;  // of the agent at the end of the last step
  const float gravity_ = ValueOf(Variant::kGravity, kGravity);
  const float takeoff_speed_ = ValueOf(Variant::kJumpSpeed, kJumpSpeed);
};

}  // namespace

extern constexpr GameSpec kCoinRun = {
    .name = "coinrun",
    .description = "A runner jumps over pits, saws and walkers to the coin at the far right.",
    .modes = kEasyHard,
    .easy_returns = {5, 10},
    .hard_returns = {5, 10},
    .exploration_level = 1949448038,
    .kinds = kKinds,
    .make = MakeGame<CoinRun>,
};

}  // namespace procgen
