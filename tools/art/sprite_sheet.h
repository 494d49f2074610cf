#ifndef TOOLS_ART_SPRITE_SHEET_H_
#define TOOLS_ART_SPRITE_SHEET_H_

#include "envcore/render/art/mipmapped_image.h"
#include "envcore/render/raster/image.h"

namespace procgen {

// A sprite as it is looked at when it is drawn: large, and under it as an agent sees it, 4, 6 and 9
// pixels long, each pixel enlarged; on a light backdrop to the left and a dark one to the right.
Image SpriteSheet(const MipmappedImage& picture);

}  // namespace procgen

#endif  // TOOLS_ART_SPRITE_SHEET_H_
