#ifndef TOOLS_ART_SPRITE_SHEET_H_
#define TOOLS_ART_SPRITE_SHEET_H_

#include "envcore/render/art/mipmapped_image.h"
#include "envcore/render/raster/image.h"

namespace procgen {

// A sprite as shown on a sheet: large, and below it 4, 6 and 9 pixels long as an agent sees it,
// each pixel enlarged. On a light backdrop at the left and a dark one at the right.
Image SpriteSheet(const MipmappedImage& picture);

}  // namespace procgen

#endif  // TOOLS_ART_SPRITE_SHEET_H_
