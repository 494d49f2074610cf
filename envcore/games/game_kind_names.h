#ifndef ENVCORE_GAMES_GAME_KIND_NAMES_H_
#define ENVCORE_GAMES_GAME_KIND_NAMES_H_

#include <optional>
#include <string>

#include "absl/strings/string_view.h"
#include "absl/types/span.h"

namespace procgen {

// The name of a kind of entities or cells of a game, in states and tables that people and programs
// read. Rules do not use names.
struct KindName {
  int kind = 0;
  absl::string_view name;
  bool is_goal = false;  // to reach it, or all of it, completes the level
};

// The kinds of a game, without those of CommonKindNames. Empty for an unknown game.
absl::Span<const KindName> KindNamesOf(absl::string_view game);
// Kinds with the same meaning in all games: agent, wall, explosion, trail, empty.
absl::Span<const KindName> CommonKindNames();

// Returns the name of a kind; empty if it has none.
absl::string_view NameOfKind(absl::string_view game, int kind);
std::optional<int> FindKind(absl::string_view game, absl::string_view name);
// All names, for messages: "agent, wall, ...".
std::string AllKindNames(absl::string_view game);

}  // namespace procgen

#endif  // ENVCORE_GAMES_GAME_KIND_NAMES_H_
