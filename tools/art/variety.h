#ifndef TOOLS_ART_VARIETY_H_
#define TOOLS_ART_VARIETY_H_

#include <cstdint>

#include "absl/types/span.h"
#include "envcore/pool/shared_art.h"
#include "tools/art/roles.h"

namespace procgen {

// The colors of one view, in CIELAB.
struct ViewColors {
  double lightness = 0;  // mean, in [0, 100]
  double contrast = 0;   // standard deviation of the lightness
  double chroma = 0;     // mean
  double grain = 0;      // mean lightness difference of horizontal neighbors
  double a = 0;          // mean
  double b = 0;
};

// How much the first views of a game's levels differ. Spreads are standard deviations over the
// levels.
struct Variety {
  double lightness = 0;
  double lightness_spread = 0;
  double contrast = 0;
  double contrast_spread = 0;
  double chroma = 0;
  double chroma_spread = 0;
  double hue_spread = 0;    // circular standard deviation of the mean colors' hues, degrees
  double color_spread = 0;  // root mean square distance of the views' mean colors from their mean
  double grain = 0;
};

// Measures levels 0 to 999 of a game in the mode of its roles.
Variety MeasureVariety(const Roles& roles, const SharedArt& art);

// The colors of a square view, uint8 [side_px, side_px, 3]. REQUIRES: side_px is at least 2.
ViewColors ColorsOf(absl::Span<const uint8_t> rgb, int side_px);

// REQUIRES: there is a view.
Variety SpreadOf(absl::Span<const ViewColors> views);

}  // namespace procgen

#endif  // TOOLS_ART_VARIETY_H_
