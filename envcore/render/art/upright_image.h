#ifndef ENVCORE_RENDER_ART_UPRIGHT_IMAGE_H_
#define ENVCORE_RENDER_ART_UPRIGHT_IMAGE_H_

#include <cstdint>

#include "absl/types/span.h"
#include "envcore/render/art/column_copies.h"
#include "envcore/render/output/frame.h"
#include "envcore/render/raster/image.h"
#include "envcore/render/raster/pixel_set.h"
#include "envcore/render/raster/rotated_rect.h"

namespace procgen {

// The source column (or row) of successive pixel columns, from pixel column `first` on.
struct SourcePositions {
  int end() const { return first + static_cast<int>(sources.size()); }

  int first = 0;
  absl::Span<const int32_t> sources;
};

// Draws the pixels of `image` at the given positions. `opaque`: whether all pixels of the image are
// opaque. REQUIRES: the positions are in the frame, their sources in the image.
void DrawAtPositions(const Image& image, bool opaque, const SourcePositions& across,
                     const SourcePositions& down, const Frame& frame);
// Draws `image` stretched into `rect`; each pixel shows one source pixel. `opaque`: whether all
// pixels of the image are opaque. `opacity`: a factor for Mul.
void DrawUpright(const Image& image, bool opaque, uint32_t opacity, const ScreenRect& rect,
                 const Frame& frame);
// Draws `image` upside down. REQUIRES: rotated.IsHalfTurn().
void DrawHalfTurn(const Image& image, bool opaque, uint32_t opacity, const RotatedRect& rotated,
                  const Frame& frame);
// How the rectangle of a background moves from frame to frame.
enum class BackdropMotion { kAny, kSideways };

// Draws a background; its colors are copied unchanged. `copies`: of the image; null: none.
// `pixels`: the pixels to skip, updated with those done; null: draws all pixels.
void DrawBackdrop(const Image& image, const ScreenRect& rect, BackdropMotion motion,
                  const ColumnCopies* copies, BackdropPixels* pixels, const Frame& frame);

}  // namespace procgen

#endif  // ENVCORE_RENDER_ART_UPRIGHT_IMAGE_H_
