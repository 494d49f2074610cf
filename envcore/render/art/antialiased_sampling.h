#ifndef ENVCORE_RENDER_ART_ANTIALIASED_SAMPLING_H_
#define ENVCORE_RENDER_ART_ANTIALIASED_SAMPLING_H_

#include "envcore/render/art/mipmapped_image.h"
#include "envcore/render/output/frame.h"
#include "envcore/scene/camera.h"

namespace procgen {

// Draws a picture into a rectangle for the eye: source pixels are interpolated, and pixels at its
// edges weighted by the part of them that is covered. `rotation` in radians, `opacity` in [0, 1].
void DrawAntialiased(const MipmappedImage& picture, const ScreenRect& rect, float rotation,
                     float opacity, const Frame& frame);

}  // namespace procgen

#endif  // ENVCORE_RENDER_ART_ANTIALIASED_SAMPLING_H_
