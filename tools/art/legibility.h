#ifndef TOOLS_ART_LEGIBILITY_H_
#define TOOLS_ART_LEGIBILITY_H_

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "envcore/pool/shared_art.h"
#include "envcore/render/output/pixel.h"
#include "tools/art/roles.h"

namespace procgen {

// A crop of an agent's view, with a part or nothing at its center: opaque pixels, row by row.
inline constexpr int kWindowSizePx = 24;
using Window = std::array<Rgba, kWindowSizePx * kWindowSizePx>;

// The image of a part.
struct Appearance {
  int image_kind = kDotImage;
  int theme = 0;
};

// The smallest distance between two parts, or between a part and its backdrop.
struct PartDistance {
  const Part* first = nullptr;
  const Part* second = nullptr;  // null: the backdrop
  float distance = 0;            // README.md, "The distance"
  // Where the distance is smallest.
  Appearance first_appearance;
  Appearance second_appearance;
  std::string backdrop;  // "background 12", "image kind 2 theme 0"
};

// Compares all pairs of parts of a game that must be distinguishable, and each part with its
// backdrops. Returns them by distance, smallest first.
std::vector<PartDistance> CompareParts(const Roles& roles, const SharedArt& art);

}  // namespace procgen

#endif  // TOOLS_ART_LEGIBILITY_H_
