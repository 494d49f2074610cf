#ifndef ENVCORE_RENDER_SCALED_DRAWING_H_
#define ENVCORE_RENDER_SCALED_DRAWING_H_

#include <cstdint>

#include "envcore/render/frame.h"
#include "envcore/render/hidden_pixels.h"
#include "envcore/render/scaled_pictures.h"

namespace procgen {

// Draws a picture that has its size, its top left pixel at (left, top), anywhere in the frame or
// outside. `opacity`: a factor of Mul, 255 for all.
void DrawScaled(const ScaledPicture& picture, int left, int top, uint32_t opacity,
                const Frame& frame);
// Draws one that is opaque, but for the pixels that may be left out; null: none.
void DrawScaledShown(const ScaledPicture& picture, int left, int top, const HiddenPixels* hidden,
                     const Frame& frame);

}  // namespace procgen

#endif  // ENVCORE_RENDER_SCALED_DRAWING_H_
