// BigFish: a small fish in a tank, seen from the side. Eating a fish that is not wider than the
// agent pays +1 and makes the agent grow a little. Touching a wider one ends the episode. After 30
// eaten fish the level is complete (+10).

#include <cmath>

#include "envcore/games/game.h"
#include "envcore/games/game_spec.h"

namespace procgen {
namespace {

constexpr int kFishKind = 2;

constexpr KindName kKinds[] = {{kFishKind, "fish"}};

constexpr int kWorldSide = 20;         // cells
constexpr float kAgentRadiusEasy = 1;  // cells, at the start of a level
constexpr float kAgentRadiusHard = 0.5F;
constexpr float kAgentRadiusGrown = 2;  // when all fish are eaten
constexpr int kFishNeeded = 30;
constexpr int kFishEatenMax = 1000;  // limit in a snapshot; can exceed the goal in the last step
constexpr float kFishReward = 1;
constexpr float kCompletionReward = 10;
constexpr int kSpawnChance = 10;         // one new fish per this many steps, on average
constexpr double kFishRadiusMin = 0.25;  // cells
constexpr double kFishRadiusRange = 1.75;
constexpr double kFishRadiusExponent = 1.4;  // small fish are more frequent
constexpr double kFishSpeedMin = 0.15;       // cells per step
constexpr double kFishSpeedRange = 0.25;

constexpr ArtSlot kArtSlots[] = {
    {0, 0, "agent", "misc_assets/fishTile_072.png", 108, 76},
    {2, 0, "fish", "misc_assets/fishTile_074.png", 78, 46},
    {2, 1, "fish", "misc_assets/fishTile_078.png", 112, 88},
    {2, 2, "fish", "misc_assets/fishTile_080.png", 108, 58},
};

constexpr GameArtSpec kArt = {.slots = kArtSlots, .background_group = BackgroundGroup::kWater};

class BigFish final : public Game {
 public:
  explicit BigFish(const GameOptions& options) : Game(kArt, options) {}

 private:
  void MakeLevel() override {
    StandardReset(kWorldSide, kWorldSide);
    center_agent_ = false;
    fish_eaten_ = 0;
    const float start_radius = options().distribution_mode == DistributionMode::kEasy
                                   ? kAgentRadiusEasy
                                   : kAgentRadiusHard;
    growth_ = (kAgentRadiusGrown - start_radius) / kFishNeeded;
    // x was drawn for a smaller body and is not corrected: the agent may extend beyond the sides.
    Entity& agent = world_.agent();
    agent.rx = start_radius;
    agent.ry = start_radius;
    agent.y = 1 + start_radius;
  }

  void PlayStep() override {
    StandardStep();
    if (random_.Int(kSpawnChance) == 1) {
      SpawnFish();
    }
    if (fish_eaten_ >= kFishNeeded) {
      outcome_.done = true;
      outcome_.reward += kCompletionReward;
      outcome_.level_complete = true;
    }
    if (world_.controls.horizontal != 0) {
      world_.agent().mirrored = world_.controls.horizontal < 0;
    }
  }

  void SpawnFish() {
    const double size_share = random_.Unit();
    const auto radius = static_cast<float>(
        kFishRadiusRange * std::pow(size_share, kFishRadiusExponent) + kFishRadiusMin);
    const float y = random_.Unit() * (kWorldSide - 2 * radius);
    const bool swims_right = random_.Unit() < 0.5F;
    const double speed_share = random_.Unit();
    const auto vx = static_cast<float>((kFishSpeedMin + speed_share * kFishSpeedRange) *
                                       (swims_right ? 1 : -1));
    const float x = swims_right ? -radius : kWorldSide + radius;
    Entity& fish =
        world_.entities.emplace_back(Entity::Make(kFishKind, x, y, vx, 0, radius, radius));
    fish.theme = DrawTheme(kFishKind);
    fish.ry = radius / AspectRatio(kFishKind, fish.theme);
    fish.mirrored = !swims_right;
  }

  void OnAgentContact(Entity& other) override {
    if (other.kind != kFishKind) {
      return;
    }
    Entity& agent = world_.agent();
    if (other.rx > agent.rx) {
      outcome_.done = true;
      return;
    }
    outcome_.reward += kFishReward;
    other.marked = true;
    agent.rx += growth_;
    agent.ry += growth_;
    ++fish_eaten_;
  }

  void VisitOwnState(StateArchive& archive) override {
    archive.Int("fish_eaten", fish_eaten_, 0, kFishEatenMax);
  }

  int32_t fish_eaten_ = 0;
  float growth_ = 0;  // of the agent's half-sizes per eaten fish, cells
};

}  // namespace

extern constexpr GameSpec kBigFish = {
    .name = "bigfish",
    .description = "A fish eats smaller fish to grow and avoids larger ones.",
    .modes = kEasyHard,
    .step_limit = 6000,
    .easy_returns = {1, 40},
    .hard_returns = {0, 40},
    .kinds = kKinds,
    .make = MakeGame<BigFish>,
};

}  // namespace procgen
