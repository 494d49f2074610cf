#ifndef ENVCORE_POOL_UPSTREAM_IMAGES_H_
#define ENVCORE_POOL_UPSTREAM_IMAGES_H_

#include <vector>

#include "envcore/render/art/art_dir.h"

namespace procgen {

// The images that an art folder in the layout of Procgen 0.10.7 must contain: each image that a
// slot or background of any game names, once, sorted by path. Sprites must have the size of their
// slots. Backgrounds may have any size, because no rule depends on it.
std::vector<RequiredImage> UpstreamImages();

}  // namespace procgen

#endif  // ENVCORE_POOL_UPSTREAM_IMAGES_H_
