#include "envcore/render/scene/rasteriser.h"

#include <algorithm>
#include <bit>

#include "envcore/level/generated_art.h"
#include "envcore/render/art/generated_painting.h"
#include "envcore/render/output/frame_packing.h"
#include "envcore/render/scene/scene_drawing.h"

namespace procgen {
namespace {

constexpr uint64_t kMultiplier = 0x9E3779B97F4A7C15;  // mixes bits

// Identifies generated art by its painting steps.
uint64_t FingerprintOf(const GeneratedArt& art) {
  uint64_t hash = static_cast<uint64_t>(art.size_px);
  const auto add = [&hash](uint64_t value) {
    hash = (hash ^ value) * kMultiplier;
    hash ^= hash >> 29;
  };
  for (const PaintStep& step : art.steps) {
    for (const double place : {step.x, step.y, step.width, step.height}) {
      add(std::bit_cast<uint64_t>(place));
    }
    uint64_t colors = static_cast<uint64_t>(step.shape);
    for (const uint8_t channel : step.fill) {
      colors = colors << 8 | channel;
    }
    for (const uint8_t channel : step.outline) {
      colors = colors << 8 | channel;
    }
    add(colors << 8 | step.alpha);
  }
  return hash;
}

}  // namespace

void Rasteriser::DrawAgentView(const Scene& scene, const GameArt& art,
                               StaticLayerCache* static_layer, const FrameFormat& format,
                               absl::Span<uint8_t> frame) {
  const Frame canvas = CanvasOf(format.size_px);
  DrawNearestScene(scene, art, BackgroundOf(scene, art), &cells_, static_layer, &rows_, canvas);
  Pack(canvas, format, frame);
}

void Rasteriser::Pack(const Frame& canvas, const FrameFormat& format, absl::Span<uint8_t> frame) {
  const int side = canvas.size_px;
  if (format.color != Color::kRgb || format.layout != Layout::kHwc) {
    rows_.Materialize(0, side, canvas);
  }
  const uint64_t shared = rows_.shared();
  if (shared == 0) {
    PackFrame(pixels_, format.color, format.layout, frame);
    return;
  }
  const auto rows_of_frame = [&](int first, int end) {
    return frame.subspan(canvas.Rows(0, first).size() * 3, canvas.Rows(first, end).size() * 3);
  };
  ForEachBitRun(shared, [&](int first, int end) {
    const absl::Span<const uint8_t> kept = rows_.layer()->Rows(first, end);
    std::copy(kept.begin(), kept.end(), rows_of_frame(first, end).begin());
  });
  ForEachBitRun(BitRange(0, side) & ~shared, [&](int first, int end) {
    PackFrame(canvas.Rows(first, end), format.color, format.layout, rows_of_frame(first, end));
  });
}

void Rasteriser::DrawHumanView(const Scene& scene, const GameArt& art, int32_t size_px,
                               absl::Span<uint8_t> frame) {
  const Frame canvas = CanvasOf(size_px);
  DrawAntialiasedScene(scene, art, BackgroundOf(scene, art), canvas);
  PackFrame(pixels_, Color::kRgb, Layout::kHwc, frame);
}

Frame Rasteriser::CanvasOf(int32_t size_px) {
  pixels_.resize(static_cast<size_t>(size_px) * static_cast<size_t>(size_px));
  return {pixels_.data(), size_px};
}

const MipmappedImage* Rasteriser::BackgroundOf(const Scene& scene, const GameArt& art) {
  if (!scene.background.shown) {
    return nullptr;
  }
  if (scene.background.generated != nullptr) {
    return &Painted(*scene.background.generated);
  }
  return art.BackgroundOf(scene.background.group, scene.background.index);
}

const MipmappedImage& Rasteriser::Painted(const GeneratedArt& art) {
  const uint64_t fingerprint = FingerprintOf(art);
  ++uses_;
  auto* slot = std::find_if(painted_.begin(), painted_.end(), [&](const PaintedBackground& p) {
    return !p.picture.empty() && p.fingerprint == fingerprint;
  });
  if (slot == painted_.end()) {
    slot = std::min_element(painted_.begin(), painted_.end(),
                            [](const PaintedBackground& a, const PaintedBackground& b) {
                              return a.last_use < b.last_use;
                            });
    slot->fingerprint = fingerprint;
    slot->picture = MipmappedImage(PaintGenerated(art), Levels::kOne);
  }
  slot->last_use = uses_;
  return slot->picture;
}

}  // namespace procgen
