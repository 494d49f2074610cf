#ifndef ENVCORE_RENDER_ART_GENERATED_PAINTING_H_
#define ENVCORE_RENDER_ART_GENERATED_PAINTING_H_

#include "envcore/level/generated_art.h"
#include "envcore/render/raster/image.h"

namespace procgen {

// Paints generated art: an image of size_px x size_px pixels, each opaque or transparent.
Image PaintGenerated(const GeneratedArt& art);

}  // namespace procgen

#endif  // ENVCORE_RENDER_ART_GENERATED_PAINTING_H_
