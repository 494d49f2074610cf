#ifndef TOOLS_PICTURES_SPRITE_CARD_H_
#define TOOLS_PICTURES_SPRITE_CARD_H_

#include "envcore/render/art/mipmapped_image.h"
#include "envcore/render/raster/image.h"

namespace procgen {

// A sprite as it is looked at when it is drawn: large, and under it as an agent sees it, 4, 6 and 9
// pixels long, each pixel enlarged; on light ground to the left and on dark ground to the right.
Image SpriteCard(const MipmappedImage& picture);

}  // namespace procgen

#endif  // TOOLS_PICTURES_SPRITE_CARD_H_
