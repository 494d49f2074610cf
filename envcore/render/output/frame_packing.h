#ifndef ENVCORE_RENDER_OUTPUT_FRAME_PACKING_H_
#define ENVCORE_RENDER_OUTPUT_FRAME_PACKING_H_

#include <cstdint>

#include "absl/types/span.h"
#include "envcore/render/output/frame_format.h"
#include "envcore/render/output/pixel.h"

namespace procgen {

// Writes `pixels`, [n], to `frame` in the given format: uint8 [n, 3] or [3, n] for RGB, [n] for
// grayscale.
// REQUIRES: frame.size() is 3 * pixels.size(), or pixels.size() for grayscale.
void PackFrame(absl::Span<const Rgba> pixels, Color color, Layout layout,
               absl::Span<uint8_t> frame);

// Converts RGB, uint8 [n, 3], to opaque pixels [n]. REQUIRES: the sizes match.
void UnpackRgb(absl::Span<const uint8_t> rgb, absl::Span<Rgba> pixels);

}  // namespace procgen

#endif  // ENVCORE_RENDER_OUTPUT_FRAME_PACKING_H_
