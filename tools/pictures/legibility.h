#ifndef TOOLS_PICTURES_LEGIBILITY_H_
#define TOOLS_PICTURES_LEGIBILITY_H_

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/functional/function_ref.h"
#include "envcore/pool/shared_art.h"
#include "envcore/render/output/pixel.h"
#include "tools/pictures/cast.h"

namespace procgen {

// A piece of an agent's view with a thing, or nothing, in its middle: opaque pixels, row by row.
inline constexpr int kWindowSizePx = 24;
using Window = std::array<Rgba, kWindowSizePx * kWindowSizePx>;

// What a part shows.
struct Appearance {
  int image_kind = kDotImage;
  int theme = 0;
};

// How hard two parts are to tell apart, or a part from the ground behind it, at their worst.
struct Likeness {
  const Part* first = nullptr;
  const Part* second = nullptr;  // null: the ground
  float distance = 0;            // README.md, "The distance"
  // Where it is that small.
  Appearance first_appearance;
  Appearance second_appearance;
  std::string ground;  // "background 12", "image kind 2 theme 0"
  Window first_window;
  Window second_window;
};

// Compares all parts of a cast that must be told apart, and each with its grounds; the least
// distance first. `show` is told how many of how many grounds are done.
std::vector<Likeness> CompareParts(const Cast& cast, const SharedArt& art,
                                   absl::FunctionRef<void(int64_t, int64_t)> show);

}  // namespace procgen

#endif  // TOOLS_PICTURES_LEGIBILITY_H_
