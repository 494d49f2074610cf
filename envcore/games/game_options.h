#ifndef ENVCORE_GAMES_GAME_OPTIONS_H_
#define ENVCORE_GAMES_GAME_OPTIONS_H_

#include <cstdint>

namespace procgen {

// How levels are generated. The numbers are those of Procgen 0.10.7 (upstream). kExploration, which
// has no number there, stands for one hard level per game and is resolved before a game is made.
enum class DistributionMode : int32_t {
  kEasy = 0,
  kHard = 1,
  kExtreme = 2,
  kMemory = 10,
  kExploration = 20,
};

// Actions are in [0, kActionCount): nine moves (the directions of the numeric keypad, column by
// column from the left) and six special keys. kEndEpisodeAction does nothing and ends the episode.
inline constexpr int32_t kActionCount = 15;
inline constexpr int32_t kNoAction = 4;
inline constexpr int32_t kEndEpisodeAction = -1;

// How a level differs from upstream's, once it is generated (game_variants.h). Snapshots contain
// the numbers: never renumber them.
enum class Variant : int32_t {
  kNone = 0,
  kCoinRandom = 1,
  kCheeseCorner = 2,
  kTwoObjects = 3,
  // Those with a value, in place of a constant of the game.
  kGravity = 4,
  kJumpSpeed = 5,
  kEnemySpeed = 6,
  kThrustSpeed = 7,
};
inline constexpr auto kVariantMax = static_cast<int32_t>(Variant::kThrustSpeed);

// The options that a game reads, with upstream's names and Python defaults.
struct GameOptions {
  DistributionMode distribution_mode = DistributionMode::kHard;
  bool center_agent = true;            // the camera follows the agent; some games ignore it
  bool use_backgrounds = true;         // false: black background
  bool use_generated_assets = false;   // art from random numbers; changes sizes and levels
  bool use_monochrome_assets = false;  // flat rectangles; changes no level
  bool restrict_themes = false;        // one theme per kind; changes no draw
  bool paint_vel_info = false;         // draw two squares that show the agent's velocity
  int32_t debug_mode = 0;              // bit flags; only coinrun reads them
  Variant variant = Variant::kNone;    // not of upstream
  float variant_value = 0;             // of a variant with a value
};

}  // namespace procgen

#endif  // ENVCORE_GAMES_GAME_OPTIONS_H_
