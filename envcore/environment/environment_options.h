#ifndef ENVCORE_ENVIRONMENT_ENVIRONMENT_OPTIONS_H_
#define ENVCORE_ENVIRONMENT_ENVIRONMENT_OPTIONS_H_

#include <cstdint>

#include "absl/strings/string_view.h"
#include "envcore/games/game_catalog.h"
#include "envcore/games/game_options.h"
#include "envcore/games/game_variants.h"
#include "envcore/status/status.h"

namespace procgen {

// The options of an environment, with the names and Python defaults of Procgen 0.10.7.
struct EnvironmentOptions : GameOptions {
  int32_t num_levels = 0;              // number of levels, >= 0; 0: unlimited
  int32_t start_level = 0;             // first level seed, >= 0; unused when num_levels is 0
  int64_t rand_seed = 0;               // seeds the level-seed stream, modulo 2^32
  bool use_sequential_levels = false;  // a completed level is followed by level seed + 997
};

// Returns the game with this name. Errors: NOT_FOUND (the message names all games).
StatusOr<const GameSpec*> RequireGame(absl::string_view name);

// Sets the variant by its text, as SetVariant. Errors: INVALID_ARGUMENT (the message names all
// variants with their games).
Status RequireVariant(absl::string_view text, GameOptions* options);

// Checks `options` for `game` and returns them with kExploration resolved: hard mode with one
// level, whose seed depends on the game. Errors: NOT_FOUND: no such game. INVALID_ARGUMENT: an
// option is out of range, or the game does not have the mode (the message says what is allowed).
StatusOr<EnvironmentOptions> ResolveOptions(absl::string_view game,
                                            const EnvironmentOptions& options);

}  // namespace procgen

#endif  // ENVCORE_ENVIRONMENT_ENVIRONMENT_OPTIONS_H_
