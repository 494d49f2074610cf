#ifndef ENVCORE_POOL_UPSTREAM_IMAGES_H_
#define ENVCORE_POOL_UPSTREAM_IMAGES_H_

#include <vector>

#include "envcore/render/art/art_folder.h"

namespace procgen {

// The pictures that an art folder in the layout of Procgen 0.10.7 must have: every one that a slot
// or a background of any game names, each once, sorted by path. Sprites have the size of their
// slots; backgrounds may have any, as no rule follows from it.
std::vector<RequiredImage> UpstreamImages();

}  // namespace procgen

#endif  // ENVCORE_POOL_UPSTREAM_IMAGES_H_
