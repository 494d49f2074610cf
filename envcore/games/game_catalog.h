#ifndef ENVCORE_GAMES_GAME_CATALOG_H_
#define ENVCORE_GAMES_GAME_CATALOG_H_

#include <cstdint>
#include <optional>

#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "envcore/games/game_options.h"
#include "envcore/games/game_spec.h"

namespace procgen {

// The sixteen games, sorted by name.
absl::Span<const GameSpec> GameCatalog();

// Returns the game with this name, or null.
const GameSpec* FindGame(absl::string_view name);

// "easy", "hard", "extreme", "memory", "exploration".
absl::string_view DistributionModeName(DistributionMode mode);
std::optional<DistributionMode> FindDistributionMode(absl::string_view name);

// The name of an action by its keys, from "LEFT+DOWN" to "E". REQUIRES: action in [0,
// kActionCount).
absl::string_view ActionName(int32_t action);

}  // namespace procgen

#endif  // ENVCORE_GAMES_GAME_CATALOG_H_
