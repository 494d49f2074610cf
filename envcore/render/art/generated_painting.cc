#include "envcore/render/art/generated_painting.h"

#include <algorithm>

#include "envcore/render/raster/ellipse.h"
#include "envcore/render/raster/flat_rectangle.h"
#include "envcore/render/raster/runs.h"

namespace procgen {
namespace {

Rgba Opaque(const Rgb& color) { return {color[0], color[1], color[2], 255}; }

void PaintRectangle(const PaintStep& step, Image& image) {
  const PixelBox box =
      CoveredPixels({step.x, step.y, step.width, step.height}, image.width(), image.height());
  const Rgba color = PremultipliedFlat({step.fill[0], step.fill[1], step.fill[2], step.alpha});
  for (int y = box.top; y < box.bottom; ++y) {
    Rgba* row = image.Row(y);
    if (color.alpha == 255) {
      std::fill(row + box.left, row + box.right, color);
      continue;
    }
    for (int x = box.left; x < box.right; ++x) {
      const Rgba below = Mul(row[x], 255U - color.alpha);
      row[x] = {static_cast<uint8_t>(color.red + below.red),
                static_cast<uint8_t>(color.green + below.green),
                static_cast<uint8_t>(color.blue + below.blue),
                static_cast<uint8_t>(color.alpha + below.alpha)};
    }
  }
}

void PaintEllipse(const PaintStep& step, Image& image) {
  const ScreenRect rect = {step.x, step.y, step.width, step.height};
  const auto paint_with = [&image](const Rgba& color) {
    return [&image, color](int row, int first, int end) {
      std::fill(image.Row(row) + first, image.Row(row) + end, color);
    };
  };
  EmitEllipse(rect, image.width(), paint_with(Opaque(step.fill)), paint_with(Opaque(step.outline)));
}

}  // namespace

Image PaintGenerated(const GeneratedArt& art) {
  Image image(art.size_px, art.size_px);
  for (const PaintStep& step : art.steps) {
    if (step.shape == PaintStep::Shape::kRectangle) {
      PaintRectangle(step, image);
    } else {
      PaintEllipse(step, image);
    }
  }
  return image;
}

}  // namespace procgen
