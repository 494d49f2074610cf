#ifndef TOOLS_ART_LEGIBILITY_H_
#define TOOLS_ART_LEGIBILITY_H_

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/functional/function_ref.h"
#include "envcore/pool/shared_art.h"
#include "envcore/render/output/pixel.h"
#include "tools/art/roles.h"

namespace procgen {

// A piece of an agent's view with a thing, or nothing, in its middle: opaque pixels, row by row.
inline constexpr int kWindowSizePx = 24;
using Window = std::array<Rgba, kWindowSizePx * kWindowSizePx>;

// What a part shows.
struct Appearance {
  int image_kind = kDotImage;
  int theme = 0;
};

// How hard two parts are to tell apart, or a part from the backdrop behind it, at their worst.
struct Likeness {
  const Part* first = nullptr;
  const Part* second = nullptr;  // null: the backdrop
  float distance = 0;            // README.md, "The distance"
  // Where it is that small.
  Appearance first_appearance;
  Appearance second_appearance;
  std::string backdrop;  // "background 12", "image kind 2 theme 0"
  Window first_window;
  Window second_window;
};

// Compares all parts of a game that must be told apart, and each with its backdrops; the least
// distance first. `show` is told how many of how many backdrops are done.
std::vector<Likeness> CompareParts(const Roles& roles, const SharedArt& art,
                                   absl::FunctionRef<void(int64_t, int64_t)> show);

}  // namespace procgen

#endif  // TOOLS_ART_LEGIBILITY_H_
