#ifndef ENVCORE_ENVIRONMENT_ENVIRONMENT_OPTIONS_H_
#define ENVCORE_ENVIRONMENT_ENVIRONMENT_OPTIONS_H_

#include <cstdint>
#include <string_view>

#include "absl/status/status.h"
#include "envcore/games/game.h"

namespace procgen {

// What an environment is made with: the released benchmark's options, by their names, with its
// Python defaults.
struct EnvironmentOptions {
  DistributionMode distribution_mode = DistributionMode::kHard;
  int32_t num_levels = 0;   // number of different levels, >= 0; 0: unlimited
  int32_t start_level = 0;  // first level seed, >= 0; not used with num_levels 0
  int64_t rand_seed = 0;    // seeds the choice of levels, modulo 2^32
  bool use_sequential_levels =
      false;  // a completed level is followed by level seed + 997 without an episode end
  bool center_agent = true;            // the camera follows the agent; some games overwrite it
  bool use_backgrounds = true;         // false: black behind everything
  bool use_generated_assets = false;   // pictures from random numbers; changes sizes and levels
  bool use_monochrome_assets = false;  // flat rectangles; changes no level
  bool restrict_themes = false;        // one theme per kind; changes no draw
  bool paint_vel_info = false;         // two squares that show the agent's velocity
  int32_t debug_mode = 0;              // bits that only coinrun reads
};

// Checks `options` for `game` and returns them with kExploration resolved to what it stands for:
// hard, one level, the game's own level seed. Errors: NOT_FOUND no such game; UNIMPLEMENTED a game
// of the suite that is not there yet; INVALID_ARGUMENT an option out of range or a mode that the
// game lacks (the message says what is allowed).
absl::StatusOr<EnvironmentOptions> ResolveOptions(std::string_view game,
                                                  EnvironmentOptions options);

}  // namespace procgen

#endif  // ENVCORE_ENVIRONMENT_ENVIRONMENT_OPTIONS_H_
