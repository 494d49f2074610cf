#ifndef ENVCORE_RENDER_FRAME_PACKING_H_
#define ENVCORE_RENDER_FRAME_PACKING_H_

#include <cstdint>

#include "absl/types/span.h"
#include "envcore/render/pixel.h"

namespace procgen {

// Writes the red, green and blue of `pixels`, [n], to `rgb`, uint8 [n, 3].
// REQUIRES: rgb.size() == 3 * pixels.size().
void PackRgb(absl::Span<const Rgba> pixels, absl::Span<uint8_t> rgb);

}  // namespace procgen

#endif  // ENVCORE_RENDER_FRAME_PACKING_H_
