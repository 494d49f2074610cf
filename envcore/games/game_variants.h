#ifndef ENVCORE_GAMES_GAME_VARIANTS_H_
#define ENVCORE_GAMES_GAME_VARIANTS_H_

#include <cstdint>
#include <string>

#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "envcore/games/game_options.h"

namespace procgen {

struct World;

// A variant of a game: its levels are upstream's with one change. An object is moved or added when
// a level begins; draws for this come from a stream of their own, so that the rest of the level,
// and every draw while it is played, are upstream's. Or a constant of the game has another value
// while a level is played; levels are generated for upstream's.
struct VariantSpec {
  Variant variant = Variant::kNone;
  absl::string_view name;
  absl::string_view game;
  absl::string_view description;  // one sentence
  float value = 0;                // upstream's; 0: the variant has no value
};
// A value is in [upstream's / kVariantValueFactor, upstream's * kVariantValueFactor].
inline constexpr float kVariantValueFactor = 4;

absl::Span<const VariantSpec> VariantCatalog();
// Returns the variant of a game; null: the game does not have it.
const VariantSpec* FindVariant(absl::string_view game, Variant variant);
// Sets the variant by its text, e.g. "coin_random" or "gravity=0.1"; "" is kNone. Returns false if
// there is none with this name, or its value is missing or not a number.
bool SetVariant(absl::string_view text, GameOptions* options);
// Its text, from which SetVariant makes the same; "" for kNone.
std::string VariantText(Variant variant, float value);
std::string VariantText(const VariantSpec& spec);

// Changes the world of a new level. kNone changes nothing.
void ApplyVariant(Variant variant, int32_t level_seed, World* world);

}  // namespace procgen

#endif  // ENVCORE_GAMES_GAME_VARIANTS_H_
