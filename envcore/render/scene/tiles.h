#ifndef ENVCORE_RENDER_SCENE_TILES_H_
#define ENVCORE_RENDER_SCENE_TILES_H_

#include <algorithm>

#include "envcore/scene/camera.h"

namespace procgen {

// Largest number of tiles. The games use fewer than a hundred; the limit is for boxes of almost no
// breadth.
inline constexpr int kTileCountMax = 1000;

// The number of tiles, of aspect ratio `ratio`, along a rectangle of `length` x `breadth`.
inline int TileCount(double length, double breadth, double ratio) {
  const double count = length / (breadth * ratio);
  return count >= 1 ? static_cast<int>(std::min<double>(count, kTileCountMax)) : 1;
}

// Calls `draw` for each tile of `rect`: side by side for a positive ratio, one below the other for
// a negative one. REQUIRES: ratio != 0.
template <typename Draw>
void ForEachTile(const ScreenRect& rect, float ratio, Draw draw) {
  if (ratio > 0) {
    const int count = TileCount(rect.width, rect.height, static_cast<double>(ratio));
    const auto width = static_cast<float>(rect.width / count);
    const auto height = static_cast<float>(rect.height);
    for (int i = 0; i < count; ++i) {
      const float offset = width * static_cast<float>(i);
      draw(ScreenRect{rect.x + static_cast<double>(offset), rect.y, static_cast<double>(width),
                      static_cast<double>(height)});
    }
    return;
  }
  const int count = TileCount(rect.height, rect.width, static_cast<double>(-ratio));
  const auto width = static_cast<float>(rect.width);
  const auto height = static_cast<float>(rect.height / count);
  for (int i = 0; i < count; ++i) {
    const float offset = height * static_cast<float>(i);
    draw(ScreenRect{rect.x, rect.y + static_cast<double>(offset), static_cast<double>(width),
                    static_cast<double>(height)});
  }
}

}  // namespace procgen

#endif  // ENVCORE_RENDER_SCENE_TILES_H_
