// Heist: a thief steals a gem (+10, level complete) from a maze whose passages are closed by up to
// three colored locks. Each lock opens with the key of its color, which is reachable before the
// lock. Taken keys are shown in the upper right corner. Nothing kills the thief.

#include <algorithm>
#include <array>

#include "envcore/games/game.h"
#include "envcore/games/game_spec.h"
#include "envcore/level/maze.h"
#include "envcore/world/direction.h"
#include "envcore/world/placing.h"

namespace procgen {
namespace {

constexpr int kLockKind = 1;
constexpr int kKeyKind = 2;
constexpr int kGemKind = 9;
constexpr int kKeyDisplayKind = 11;

constexpr KindName kKinds[] = {{kLockKind, "lock"},
                               {kKeyKind, "key"},
                               {kGemKind, "gem", true},
                               {kKeyDisplayKind, "key_display"}};

constexpr int kWorldSideEasy = 9;  // cells
constexpr int kWorldSideHard = 13;
constexpr int kWorldSideMemory = 23;
constexpr float kCellsInViewMemory = 8;
constexpr int kMazeSizeMin = 5;  // cells; sizes are odd
constexpr int kKeyCountMax = 3;
constexpr std::array<const char*, kKeyCountMax> kKeyTakenNames = {"key_0_taken", "key_1_taken",
                                                                  "key_2_taken"};
constexpr float kRadius = 0.375F;  // cells; of the agent, and the half-width of keys and gem
constexpr float kLockRadius = 0.5F;
constexpr float kTopSpeed = 0.75F;       // cells per step
constexpr float kDisplayRadius = 0.03F;  // of the display of a taken key, in fractions of the image
constexpr double kDisplayRightGap = 1.25;  // from the right edge to the first center, in radii
constexpr double kDisplayTopGap = 0.75;    // from the top edge, in radii
constexpr float kGemReward = 10;

constexpr ArtSlot kArtSlots[] = {
    {0, 0, "thief", "misc_assets/spaceAstronauts_008.png", 37, 44},
    {1, 0, "lock", "misc_assets/lock_blue.png", 70, 70},
    {1, 1, "lock", "misc_assets/lock_green.png", 70, 70},
    {1, 2, "lock", "misc_assets/lock_red.png", 70, 70},
    {2, 0, "key", "misc_assets/keyBlue.png", 84, 52},
    {2, 1, "key", "misc_assets/keyGreen.png", 84, 52},
    {2, 2, "key", "misc_assets/keyRed.png", 84, 52},
    {9, 0, "gem", "misc_assets/gemYellow.png", 70, 48},
    {51, 0, "wall", "kenney/Ground/Dirt/dirtCenter.png", 128, 128},
};

constexpr int kBlockShapedKinds[] = {kWallKind, kLockKind};
constexpr int kKeptThemeKinds[] = {kLockKind, kKeyKind};  // their themes are the colors

constexpr GameArtSpec kArt = {.slots = kArtSlots,
                              .block_shaped_kinds = kBlockShapedKinds,
                              .kept_theme_kinds = kKeptThemeKinds,
                              .background_group = BackgroundGroup::kTopdown};

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

class Heist final : public Game {
 public:
  explicit Heist(const GameOptions& options) : Game(kArt, options) {
    shows_velocity_ = false;
    cells_in_view_ = kCellsInViewMemory;
    top_speed_ = kTopSpeed;
    world_.out_of_bounds_kind = kWallKind;
  }

 private:
  // --- Level generation: a maze with doors and keys at a random position in a field of wall.

  void MakeLevel() override {
    const bool has_memory = options().distribution_mode == DistributionMode::kMemory;
    const int side = WorldSide(options().distribution_mode);
    StandardReset(side, side);
    center_agent_ = has_memory;
    const int difficulty = random_.Int((side - kMazeSizeMin) / 2 + 1);
    const int drawn_key_count =
        has_memory ? random_.Int(kKeyCountMax + 1) : difficulty + random_.Int(2);
    const int key_count = std::min(drawn_key_count, kKeyCountMax);
    key_taken_.fill(false);

    Maze maze(2 * difficulty + kMazeSizeMin);
    maze.MakeWithDoors(random_, key_count);
    PlaceMaze(maze);
    for (int i = 0; i < key_count; ++i) {
      AddKeyDisplay(i);
    }
  }

  void PlaceMaze(const Maze& maze) {
    // Away from everything until its own cell is reached.
    Entity& agent = world_.agent();
    agent.rx = kRadius;
    agent.ry = kRadius;
    agent.x = -1;
    agent.y = -1;
    const int side = world_.grid.width();
    const int left = random_.Int(side - maze.size() + 1);
    const int bottom = random_.Int(side - maze.size() + 1);
    world_.grid.Fill(0, 0, side, side, kWallKind);
    for (int x = 0; x < maze.size(); ++x) {
      for (int y = 0; y < maze.size(); ++y) {
        const int kind = maze.At(x, y);
        if (kind != kWallKind) {
          world_.grid.Set(left + x, bottom + y, kEmptyKind);
          PlaceObject(kind, left + x, bottom + y);
        }
      }
    }
  }

  // Places the object of the maze cell (x, y), if any.
  void PlaceObject(int maze_kind, int x, int y) {
    if (maze_kind >= kMazeKeyKind) {
      Entity& key = SpawnInCell(kKeyKind, x, y);
      key.theme = maze_kind - kMazeKeyKind;
      key.ry = key.rx / AspectRatio(kKeyKind, key.theme);
    } else if (maze_kind >= kMazeDoorKind) {
      Entity& lock = SpawnAtCell(world_, kLockKind, kLockRadius, world_.grid.IndexOf(x, y));
      lock.theme = maze_kind - kMazeDoorKind;
    } else if (maze_kind == kExitKind) {
      Entity& gem = SpawnInCell(kGemKind, x, y);
      gem.ry = gem.rx / AspectRatio(kGemKind, 0);
    } else if (maze_kind == kMazeStartKind) {
      world_.agent().x = static_cast<float>(x) + 0.5F;
      world_.agent().y = static_cast<float>(y) + 0.5F;
    }
  }

  Entity& SpawnInCell(int kind, int x, int y) {
    const Box cell = {
        .x = static_cast<float>(x), .y = static_cast<float>(y), .width = 1, .height = 1};
    return SpawnInBox(world_, random_, kind, kRadius, kRadius, cell);
  }

  // Displays are in a row from the right. Each shows its key, upright, once the key is taken.
  void AddKeyDisplay(int theme) {
    const double radius = kDisplayRadius;
    const auto x = static_cast<float>(1 - radius * (2 * theme + kDisplayRightGap));
    const auto y = static_cast<float>(radius * kDisplayTopGap);
    const float ry = kDisplayRadius / AspectRatio(kKeyKind, theme);
    Entity& display =
        world_.entities.emplace_back(Entity::Make(kKeyDisplayKind, x, y, 0, 0, kDisplayRadius, ry));
    display.image_kind = kKeyKind;
    display.theme = theme;
    display.rotation = kHalfPi;
    display.layer = 1;
    display.screen_coordinates = true;
  }

  // --- Step.

  void PlayStep() override {
    StandardStep();
    TurnTo(world_.agent(), world_.controls.horizontal, world_.controls.vertical, 0);
  }

  // --- Contacts.

  bool HasKeyOf(const Entity& entity) const {
    return key_taken_[static_cast<size_t>(entity.theme)];
  }

  bool EntityBlocks(const Entity& mover, const Entity& other, Axis axis) override {
    return other.kind == kLockKind ? !HasKeyOf(other) : Game::EntityBlocks(mover, other, axis);
  }

  void OnAgentContact(Entity& other) override {
    switch (other.kind) {
      case kGemKind:
        outcome_.reward = kGemReward;
        outcome_.level_complete = true;
        outcome_.done = true;
        break;
      case kKeyKind:
        other.marked = true;
        key_taken_[static_cast<size_t>(other.theme)] = true;
        break;
      case kLockKind:
        other.marked = other.marked || HasKeyOf(other);
        break;
      default:
        break;
    }
  }

  // --- Appearance.

  int ImageKindOf(const Entity& entity) const override {
    const bool hidden = entity.kind == kKeyDisplayKind && !HasKeyOf(entity);
    return hidden ? -1 : Game::ImageKindOf(entity);
  }

  void VisitOwnState(StateArchive& archive) override {
    for (size_t i = 0; i < key_taken_.size(); ++i) {
      archive.Bool(kKeyTakenNames[i], key_taken_[i]);
    }
    for (const Entity& entity : world_.entities) {
      const bool has_color =
          entity.kind == kKeyKind || entity.kind == kLockKind || entity.kind == kKeyDisplayKind;
      archive.Check(!has_color || entity.theme < kKeyCountMax, "has a key or lock of no color");
    }
    const auto lock_count =
        std::count_if(world_.entities.begin(), world_.entities.end(),
                      [](const Entity& entity) { return entity.kind == kLockKind; });
    archive.Check(lock_count <= kKeyCountMax, "has more locks than there are colors");
  }

  std::array<bool, kKeyCountMax> key_taken_ = {};  // by color
};

}  // namespace

extern constexpr GameSpec kHeist = {
    .name = "heist",
    .description = "A thief opens coloured locks with their keys to reach the gem.",
    .modes = kWithMemory,
    .easy_returns = {3.5, 10},
    .hard_returns = {2, 10},
    .exploration_level = 876640971,
    .kinds = kKinds,
    .make = MakeGame<Heist>,
};

}  // namespace procgen
