#ifndef ENVCORE_GAMES_GAME_VARIANTS_H_
#define ENVCORE_GAMES_GAME_VARIANTS_H_

#include <cstdint>
#include <optional>

#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "envcore/games/game_options.h"

namespace procgen {

struct World;

// A variant of a game: its levels are upstream's with one change, which is made when a level
// begins. Draws for the change come from a stream of their own, so that the rest of the level, and
// every draw while it is played, are upstream's.
struct VariantSpec {
  Variant variant = Variant::kNone;
  absl::string_view name;
  absl::string_view game;
  absl::string_view description;  // one sentence
};

absl::Span<const VariantSpec> VariantCatalog();
// Returns the variant with this name; "" is kNone.
std::optional<Variant> FindVariant(absl::string_view name);
// "" for kNone.
absl::string_view VariantName(Variant variant);

// Changes the world of a new level. kNone changes nothing.
void ApplyVariant(Variant variant, int32_t level_seed, World* world);

}  // namespace procgen

#endif  // ENVCORE_GAMES_GAME_VARIANTS_H_
