#ifndef ENVCORE_POOL_RELEASED_PICTURES_H_
#define ENVCORE_POOL_RELEASED_PICTURES_H_

#include <vector>

#include "envcore/render/art/art_folder.h"

namespace procgen {

// The pictures that an art folder of the released layout must have: every one that a slot or a
// background of any game names, each once, sorted by path. Sprites have the size of their slots;
// backgrounds may have any, as no rule follows from it.
std::vector<RequiredImage> ReleasedPictures();

}  // namespace procgen

#endif  // ENVCORE_POOL_RELEASED_PICTURES_H_
