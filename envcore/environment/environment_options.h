#ifndef ENVCORE_ENVIRONMENT_ENVIRONMENT_OPTIONS_H_
#define ENVCORE_ENVIRONMENT_ENVIRONMENT_OPTIONS_H_

#include <cstdint>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "envcore/games/game_options.h"

namespace procgen {

// What an environment is made with: the options of Procgen 0.10.7, by their names, with its
// Python defaults.
struct EnvironmentOptions : GameOptions {
  int32_t num_levels = 0;              // number of different levels, >= 0; 0: unlimited
  int32_t start_level = 0;             // first level seed, >= 0; not used with num_levels 0
  int64_t rand_seed = 0;               // seeds the choice of levels, modulo 2^32
  bool use_sequential_levels = false;  // a completed level goes on at level seed + 997
};

// Checks `options` for `game` and returns them with kExploration resolved to what it stands for:
// hard, one level, the game's own level seed. Errors: NOT_FOUND no such game; INVALID_ARGUMENT an
// option out of range or a mode that the game lacks (the message says what is allowed).
absl::StatusOr<EnvironmentOptions> ResolveOptions(absl::string_view game,
                                                  const EnvironmentOptions& options);

}  // namespace procgen

#endif  // ENVCORE_ENVIRONMENT_ENVIRONMENT_OPTIONS_H_
