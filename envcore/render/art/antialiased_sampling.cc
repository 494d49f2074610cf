#include "envcore/render/art/antialiased_sampling.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "envcore/render/art/upright_image.h"
#include "envcore/render/raster/coverage.h"
#include "envcore/render/raster/rotated_rect.h"

namespace procgen {
namespace {

constexpr uint32_t kFullWeight = 256;

// Two neighboring source columns or rows, and the weight of the second in 1/256.
struct Neighbours {
  int first = 0;
  int second = 0;
  uint32_t weight = 0;
};

// The neighbors of a position in source pixels, clamped to the edge.
Neighbours NeighboursOf(double place, int size) {
  const double centred = std::clamp(place - 0.5, 0.0, static_cast<double>(size - 1));
  Neighbours neighbours;
  neighbours.first = static_cast<int>(centred);
  neighbours.second = std::min(neighbours.first + 1, size - 1);
  neighbours.weight = static_cast<uint32_t>((centred - neighbours.first) * kFullWeight);
  return neighbours;
}

Rgba Interpolated(const Image& image, const Neighbours& across, const Neighbours& down) {
  const Rgba* upper = image.Row(down.first);
  const Rgba* lower = image.Row(down.second);
  const auto mix = [&](uint8_t Rgba::*channel) {
    const uint32_t left = kFullWeight - across.weight;
    const uint32_t above =
        upper[across.first].*channel * left + upper[across.second].*channel * across.weight;
    const uint32_t below =
        lower[across.first].*channel * left + lower[across.second].*channel * across.weight;
    const uint32_t sum = above * (kFullWeight - down.weight) + below * down.weight;
    return static_cast<uint8_t>((sum + (1U << 15)) >> 16);
  };
  return {mix(&Rgba::red), mix(&Rgba::green), mix(&Rgba::blue), mix(&Rgba::alpha)};
}

void LayCovered(const Rgba& source, uint32_t opacity, double coverage, Rgba* pixel) {
  const auto weight = static_cast<uint32_t>(255 * coverage);
  Rgba shown = opacity == 255 ? source : Mul(source, opacity);
  if (weight != 255) {
    shown = Mul(shown, weight);
  }
  if (shown.alpha != 0) {
    BlendOver(shown, *pixel);
  }
}

void DrawUprightAntialiased(const Image& image, const ScreenRect& rect, uint32_t opacity,
                            const Frame& frame) {
  const CoveredRange columns = CoveredColumns(rect.x, rect.width, frame.size_px);
  const CoveredRange rows = CoveredColumns(rect.y, rect.height, frame.size_px);
  const double scale_x = image.width() / rect.width;
  const double scale_y = image.height() / rect.height;
  std::array<Neighbours, kFrameSizePxMax>
      across;  // NOLINT: every element is written before it is read
  for (int x = columns.first; x < columns.end; ++x) {
    across[static_cast<size_t>(x)] = NeighboursOf((x + 0.5 - rect.x) * scale_x, image.width());
  }
  for (int y = rows.first; y < rows.end; ++y) {
    const Neighbours down = NeighboursOf((y + 0.5 - rect.y) * scale_y, image.height());
    const double row_share = rows.ShareOf(y);
    Rgba* pixel = frame.At(columns.first, y);
    for (int x = columns.first; x < columns.end; ++x, ++pixel) {
      LayCovered(Interpolated(image, across[static_cast<size_t>(x)], down), opacity,
                 row_share * columns.ShareOf(x), pixel);
    }
  }
}

// The covered fraction of a pixel on one axis of the rotated rectangle.
double CoveredShare(double place, double half_size) {
  return std::clamp(std::min(half_size, place + 0.5) - std::max(-half_size, place - 0.5), 0.0, 1.0);
}

void DrawRotatedAntialiased(const Image& image, const RotatedRect& rotated, uint32_t opacity,
                            const Frame& frame) {
  const ScreenRect& rect = rotated.unrotated();
  const double half_w = rect.width / 2;
  const double half_h = rect.height / 2;
  const double reach_x = std::abs(half_w * rotated.cos()) + std::abs(half_h * rotated.sin()) + 1;
  const double reach_y = std::abs(half_w * rotated.sin()) + std::abs(half_h * rotated.cos()) + 1;
  const Point center = rotated.center();
  const CoveredRange columns = CoveredColumns(center.x - reach_x, 2 * reach_x, frame.size_px);
  const CoveredRange rows = CoveredColumns(center.y - reach_y, 2 * reach_y, frame.size_px);
  const double scale_x = image.width() / rect.width;
  const double scale_y = image.height() / rect.height;
  for (int y = rows.first; y < rows.end; ++y) {
    Rgba* pixel = frame.At(columns.first, y);
    for (int x = columns.first; x < columns.end; ++x, ++pixel) {
      const double dx = x + 0.5 - center.x;
      const double dy = y + 0.5 - center.y;
      const double a = dx * rotated.cos() + dy * rotated.sin();
      const double b = dy * rotated.cos() - dx * rotated.sin();
      const double coverage = CoveredShare(a, half_w) * CoveredShare(b, half_h);
      if (coverage > 0) {
        const Rgba shown = Interpolated(image, NeighboursOf((a + half_w) * scale_x, image.width()),
                                        NeighboursOf((b + half_h) * scale_y, image.height()));
        LayCovered(shown, opacity, coverage, pixel);
      }
    }
  }
}

}  // namespace

void DrawAntialiased(const MipmappedImage& picture, const ScreenRect& rect, float rotation,
                     float opacity, const Frame& frame) {
  if (!(rect.width > 0) || !(rect.height > 0)) {
    return;
  }
  const uint32_t factor = OpacityFactor(opacity);
  const Image& image = picture.LevelFor(rect.width, rect.height);
  if (rotation != 0) {
    DrawRotatedAntialiased(image, RotatedRect(rect, rotation), factor, frame);
  } else if (rect.width == image.width() && rect.height == image.height()) {
    DrawUpright(image, picture.opaque(), factor, rect, frame);
  } else {
    DrawUprightAntialiased(image, rect, factor, frame);
  }
}

}  // namespace procgen
