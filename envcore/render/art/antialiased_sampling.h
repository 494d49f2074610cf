#ifndef ENVCORE_RENDER_ART_ANTIALIASED_SAMPLING_H_
#define ENVCORE_RENDER_ART_ANTIALIASED_SAMPLING_H_

#include "envcore/render/art/mipmapped_image.h"
#include "envcore/render/output/frame.h"
#include "envcore/scene/camera.h"

namespace procgen {

// Draws an image into a rectangle for the human view: bilinear interpolation, with edge pixels
// weighted by coverage. `rotation`: radians. `opacity`: in [0, 1].
void DrawAntialiased(const MipmappedImage& picture, const ScreenRect& rect, float rotation,
                     float opacity, const Frame& frame);

}  // namespace procgen

#endif  // ENVCORE_RENDER_ART_ANTIALIASED_SAMPLING_H_
