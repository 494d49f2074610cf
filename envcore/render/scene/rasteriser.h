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

// Draws scenes. Keeps what it has painted of generated backgrounds; allocates nothing for a frame
// but to paint a new one. Threads: compatible (one thread at a time): one for each worker.
class Rasteriser {
 public:
  // Draws what the agent sees; at 64 x 64 pixel by pixel as Procgen 0.10.7 does where the
  // art is the same, and by the same rules at any other side: nothing is rescaled. `static_layer`:
  // what this environment's scenes showed before, of the same art and at the same side; null:
  // nothing is known. `frame`: as `format` says. REQUIRES: 0 < format.size_px <= kFrameSizePxMax
  // and frame.size() == format.bytes().
  void DrawAgentView(const Scene& scene, const GameArt& art, StaticLayerCache* static_layer,
                     const FrameFormat& format, absl::Span<uint8_t> frame);
  // Draws the same scene for the eye, antialiased. `frame`: uint8 [size_px, size_px, 3], red,
  // green, blue, top row first.
  // REQUIRES: 0 < size_px <= kFrameSizePxMax and `frame` has that size.
  void DrawHumanView(const Scene& scene, const GameArt& art, int32_t size_px,
                     absl::Span<uint8_t> frame);

 private:
  // A generated background that was painted before, known again by its painting steps.
  struct PaintedBackground {
    uint64_t fingerprint = 0;
    uint64_t last_use = 0;
    MipmappedImage picture;
  };

  Frame CanvasOf(int32_t size_px);
  // Writes the picture on the canvas, and what is shared, to `frame`.
  void Pack(const Frame& canvas, const FrameFormat& format, absl::Span<uint8_t> frame);
  const MipmappedImage* BackgroundOf(const Scene& scene, const GameArt& art);
  const MipmappedImage& Painted(const GeneratedArt& art);

  std::vector<Rgba> pixels_;  // of the picture that is drawn
  CellDrawing cells_;
  CopyOnWriteRows rows_;
  std::array<PaintedBackground, 8> painted_;
  uint64_t uses_ = 0;
};

}  // namespace procgen

#endif  // ENVCORE_RENDER_SCENE_RASTERISER_H_
