#ifndef ENVCORE_RENDER_UPRIGHT_PICTURE_H_
#define ENVCORE_RENDER_UPRIGHT_PICTURE_H_

#include <cstdint>

#include "envcore/render/frame.h"
#include "envcore/render/hidden_pixels.h"
#include "envcore/render/image.h"
#include "envcore/render/turn.h"

namespace procgen {

// Draws `image` stretched into `rect`, each pixel showing one source pixel. `opaque`: all pixels of
// the image are; `opacity`: a factor of Mul.
void DrawUpright(const Image& image, bool opaque, uint32_t opacity, const ScreenRect& rect,
                 const Frame& frame);
// The same upside down. REQUIRES: turned.IsHalfTurn().
void DrawHalfTurned(const Image& image, bool opaque, uint32_t opacity, const TurnedRect& turned,
                    const Frame& frame);
// Draws a background: its colours are copied as they are. `hidden`: pixels that may be left out;
// null: none.
void DrawBackdrop(const Image& image, const ScreenRect& rect, const HiddenPixels* hidden,
                  const Frame& frame);

}  // namespace procgen

#endif  // ENVCORE_RENDER_UPRIGHT_PICTURE_H_
