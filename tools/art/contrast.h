#ifndef TOOLS_ART_CONTRAST_H_
#define TOOLS_ART_CONTRAST_H_

#include <cstdint>

#include "absl/types/span.h"
#include "envcore/pool/shared_art.h"
#include "tools/art/roles.h"

namespace procgen {

// The contrast of a game's agent views: means over the views of several levels.
struct Contrast {
  // Standard deviation of the red, green and blue values of a view around the view's mean color,
  // in [0, 127.5].
  double view = 0;
  // Mean color difference (CIELAB) between a view and the same view without its figures, over the
  // pixels that differ. Figures are all parts that neither block nor are harmless. 0 without them.
  double figures = 0;
};

// Measures levels 0 to 7 of a game in the mode of its roles, each after random actions. The levels
// and actions do not depend on the art.
Contrast MeasureContrast(const Roles& roles, const SharedArt& art);

// The two measures of one view. `rgb`, `rgb_bare`: uint8 [N, 3], N >= 1, the second without
// figures.
Contrast ContrastOf(absl::Span<const uint8_t> rgb, absl::Span<const uint8_t> rgb_bare);

}  // namespace procgen

#endif  // TOOLS_ART_CONTRAST_H_
