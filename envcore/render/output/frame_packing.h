#ifndef ENVCORE_RENDER_OUTPUT_FRAME_PACKING_H_
#define ENVCORE_RENDER_OUTPUT_FRAME_PACKING_H_

#include <cstdint>

#include "absl/types/span.h"
#include "envcore/render/output/frame_format.h"
#include "envcore/render/output/pixel.h"

namespace procgen {

// Writes `pixels`, [n], to `frame` in the colours and the layout of a format: uint8 [n, 3] or
// [3, n] for red, green and blue, [n] for grey.
// REQUIRES: frame.size() is 3 * pixels.size(), or for grey pixels.size().
void PackFrame(absl::Span<const Rgba> pixels, Color color, Layout layout,
               absl::Span<uint8_t> frame);

// Opaque pixels [n] of red, green and blue, uint8 [n, 3]. REQUIRES: the sizes fit.
void UnpackRgb(absl::Span<const uint8_t> rgb, absl::Span<Rgba> pixels);

}  // namespace procgen

#endif  // ENVCORE_RENDER_OUTPUT_FRAME_PACKING_H_
