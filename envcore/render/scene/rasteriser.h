#ifndef ENVCORE_RENDER_SCENE_RASTERISER_H_
#define ENVCORE_RENDER_SCENE_RASTERISER_H_

#include <array>
#include <cstdint>
#include <vector>

#include "absl/types/span.h"
#include "envcore/render/art/game_art.h"
#include "envcore/render/art/mipmapped_image.h"
#include "envcore/render/output/frame.h"
#include "envcore/render/output/frame_format.h"
#include "envcore/render/scene/cell_drawing.h"
#include "envcore/render/scene/copy_on_write_rows.h"
#include "envcore/render/scene/static_layer_cache.h"
#include "envcore/scene/scene.h"

namespace procgen {

// Draws scenes. Caches painted generated backgrounds; a frame allocates memory only to paint a new
// one. Threads: compatible; one per worker.
class Rasteriser {
 public:
  // Draws the agent's view. At 64 x 64 with upstream's art it equals Procgen 0.10.7 pixel by pixel.
  // Other sizes follow the same rules; nothing is rescaled. `static_layer`: the cache of this
  // environment, used with one art and one size only; null: no cache. `frame`: in `format`.
  // REQUIRES: 0 < format.size_px <= kFrameSizePxMax; frame.size() == format.bytes().
  void DrawAgentView(const Scene& scene, const GameArt& art, StaticLayerCache* static_layer,
                     const FrameFormat& format, absl::Span<uint8_t> frame);
  // Draws the human view, antialiased. `frame`: uint8 [size_px, size_px, 3], RGB, top row first.
  // REQUIRES: 0 < size_px <= kFrameSizePxMax; `frame` has that size.
  void DrawHumanView(const Scene& scene, const GameArt& art, int32_t size_px,
                     absl::Span<uint8_t> frame);

 private:
  // A painted generated background, identified by its painting steps.
  struct PaintedBackground {
    uint64_t fingerprint = 0;
    uint64_t last_use = 0;
    MipmappedImage picture;
  };

  Frame CanvasOf(int32_t size_px);
  // Writes the canvas and the shared rows to `frame`.
  void Pack(const Frame& canvas, const FrameFormat& format, absl::Span<uint8_t> frame);
  const MipmappedImage* BackgroundOf(const Scene& scene, const GameArt& art);
  const MipmappedImage& Painted(const GeneratedArt& art);

  std::vector<Rgba> pixels_;  // of the frame that is being drawn
  CellDrawing cells_;
  CopyOnWriteRows rows_;
  std::array<PaintedBackground, 8> painted_;
  uint64_t uses_ = 0;
};

}  // namespace procgen

#endif  // ENVCORE_RENDER_SCENE_RASTERISER_H_
