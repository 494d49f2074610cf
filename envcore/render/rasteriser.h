#ifndef ENVCORE_RENDER_RASTERISER_H_
#define ENVCORE_RENDER_RASTERISER_H_

#include <algorithm>
#include <cmath>

#include "absl/types/span.h"
#include "envcore/render/game_art.h"
#include "envcore/scene/scene.h"

namespace procgen {

// Draws scenes in flat colours; pictures are not there yet.
class Rasteriser {
 public:
  void DrawAgentView(const Scene& scene, const GameArt& /*art*/, absl::Span<uint8_t> frame) {
    std::fill(frame.begin(), frame.end(), 0);
    const Viewport view(scene.camera, 64);
    DrawSprites(scene.below_cells, view, frame);
    const CellLayer& cells = scene.cells;
    for (int x = cells.first_column; x <= cells.last_column; ++x) {
      for (int y = cells.first_row; y <= cells.last_row; ++y) {
        const int kind =
            cells.grid->Contains(x, y) ? cells.grid->At(x, y) : cells.out_of_bounds_kind;
        if (kind >= 0 && kind < kKindCount && cells.looks[kind].image_kind >= 0) {
          Fill(view.OfCell(x, y), cells.looks[kind].image_kind, cells.looks[kind].theme, frame);
        }
      }
    }
    DrawSprites(scene.above_cells, view, frame);
  }
  void DrawHumanView(const Scene& scene, const GameArt& art, int /*side_px*/,
                     absl::Span<uint8_t> frame) {
    DrawAgentView(scene, art, frame);
  }

 private:
  static int Rounded(double v) { return static_cast<int>(std::floor(v + 0.5)); }
  void DrawSprites(const std::vector<Sprite>& sprites, const Viewport& view,
                   absl::Span<uint8_t> frame) {
    for (const Sprite& sprite : sprites) {
      Fill(view.OfBox(sprite.x, sprite.y, sprite.rx, sprite.ry), sprite.image_kind, sprite.theme,
           frame);
    }
  }
  void Fill(const ScreenRect& rect, int kind, int theme, absl::Span<uint8_t> frame) {
    const int code = ((29 * (kind + 1)) % 64 + 19 * theme) % 64;
    const uint8_t color[3] = {static_cast<uint8_t>(64 * (code / 16 + 1) - 1),
                              static_cast<uint8_t>(64 * (code / 4 % 4 + 1) - 1),
                              static_cast<uint8_t>(64 * (code % 4 + 1) - 1)};
    for (int y = std::max(0, Rounded(rect.y)); y < std::min(64, Rounded(rect.y + rect.height));
         ++y) {
      for (int x = std::max(0, Rounded(rect.x)); x < std::min(64, Rounded(rect.x + rect.width));
           ++x) {
        std::copy(color, color + 3, frame.begin() + (y * 64 + x) * 3);
      }
    }
  }
};

}  // namespace procgen

#endif  // ENVCORE_RENDER_RASTERISER_H_
