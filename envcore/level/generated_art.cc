#include "envcore/level/generated_art.h"

#include <algorithm>

namespace procgen {
namespace {

constexpr int kBackgroundSizePx = 500;
constexpr int kSpriteSizePx = 64;
constexpr int kBackgroundDepth = 1;  // blocks within a block
constexpr int kBackgroundBlotches = 50;
constexpr int kInnerBlotches = 10;
constexpr int kSpriteBlotches = 5;
constexpr double kRecursionShareMax = .75;
constexpr uint8_t kGroundVeilAlpha = 200;
constexpr float kFigureBlotchMin = 0.1F;
constexpr float kFigureBlotchMax = 0.6F;

struct Rect {
  double x = 0;
  double y = 0;
  double width = 0;
  double height = 0;
};

// A range of colors: each channel is in [start, start + length].
struct Palette {
  std::array<float, 3> length;
  std::array<float, 3> start;
};

// The size range of a part, in fractions of the rectangle's smaller side.
struct Shares {
  float min = 0;
  float max = 0;
};

Palette DrawPalette(RandomStream& random) {
  Palette palette;
  for (float& length : palette.length) {
    length = random.Unit();
  }
  for (size_t i = 0; i < palette.start.size(); ++i) {
    palette.start[i] = random.Unit() * (1.0F - palette.length[i]);
  }
  random.Unit();  // required by the rules; the value is not used
  return palette;
}

Rgb DrawColor(RandomStream& random, const Palette& palette) {
  Rgb color;
  for (size_t i = 0; i < color.size(); ++i) {
    const float share = random.Unit() * palette.length[i] + palette.start[i];
    color[i] = static_cast<uint8_t>(static_cast<int>(255.0F * share));
  }
  return color;
}

Rect DrawPart(RandomStream& random, const Rect& whole, const Shares& shares) {
  const int whole_width = static_cast<int>(whole.width);
  const int whole_height = static_cast<int>(whole.height);
  const float smaller = static_cast<float>(std::min(whole_width, whole_height));
  const float extent = shares.max - shares.min;
  const float width = (random.Unit() * extent + shares.min) * smaller;
  const float height = (random.Unit() * extent + shares.min) * smaller;
  const float x_offset = random.Unit() * (static_cast<float>(whole_width) - width);
  const float y_offset = random.Unit() * (static_cast<float>(whole_height) - height);
  return {whole.x + static_cast<double>(x_offset), whole.y + static_cast<double>(y_offset),
          static_cast<double>(width), static_cast<double>(height)};
}

void AddRectangle(const Rect& rect, const Rgb& color, uint8_t alpha, GeneratedArt& art) {
  art.steps.push_back({PaintStep::Shape::kRectangle, rect.x, rect.y, rect.width, rect.height, color,
                       Rgb{0, 0, 0}, alpha});
}

// Adds one or two stripes, rectangles or ellipses, that fill `rect`.
void AddShape(RandomStream& random, const Rect& rect, const Palette& palette, GeneratedArt& art) {
  const int32_t k = random.Int(10);
  const int32_t stripes = k * k / 50 + 1;
  const bool side_by_side = random.Coin();
  const bool rectangles = random.Coin();
  const bool new_colors = random.Coin();
  Rgb first = DrawColor(random, palette);
  Rgb second = DrawColor(random, palette);
  float x = static_cast<float>(rect.x);
  float y = static_cast<float>(rect.y);
  float width = static_cast<float>(rect.width);
  float height = static_cast<float>(rect.height);
  const float left = x;
  const float top = y;
  if (side_by_side) {
    width = width / static_cast<float>(stripes);
  } else {
    height = height / static_cast<float>(stripes);
  }
  for (int32_t i = 0; i < stripes; ++i) {
    if (new_colors) {
      first = DrawColor(random, palette);
      second = DrawColor(random, palette);
    }
    if (side_by_side) {
      x = left + static_cast<float>(i) * width;
    } else {
      y = top + static_cast<float>(i) * height;
    }
    const auto shape = rectangles ? PaintStep::Shape::kRectangle : PaintStep::Shape::kEllipse;
    art.steps.push_back({shape, static_cast<double>(x), static_cast<double>(y),
                         static_cast<double>(width), static_cast<double>(height), first, second,
                         255});
  }
}

// Adds a translucent area with at least `blotches` blotches, each a shape or, down to `depth`, a
// block.
void AddBlock(  // NOLINT(misc-no-recursion): at most `depth` deep, which is at most 1
    RandomStream& random, const Rect& rect, int depth, int blotches, GeneratedArt& art) {
  const Palette palette = DrawPalette(random);
  const Rgb ground = DrawColor(random, palette);
  AddRectangle(rect, ground, 255, art);
  const float coarseness = static_cast<float>(.3 + .7 * static_cast<double>(random.Unit()));
  const Shares shares = {static_cast<float>(.05 * static_cast<double>(coarseness)),
                         static_cast<float>(.5 * static_cast<double>(coarseness))};
  const int32_t count = random.Int(blotches, 2 * blotches);
  const float recursion_share =
      static_cast<float>(static_cast<double>(random.Unit()) * kRecursionShareMax);
  for (int32_t i = 0; i < count; ++i) {
    const Rect part = DrawPart(random, rect, shares);
    if (depth > 0 && random.Unit() < recursion_share) {
      AddBlock(random, part, depth - 1, kInnerBlotches, art);
    } else {
      AddShape(random, part, palette, art);
    }
  }
  AddRectangle(rect, ground, kGroundVeilAlpha, art);
}

// A bar from one side of the canvas to the other.
Rect DrawBar(RandomStream& random, bool upright) {
  const double side = kSpriteSizePx;
  const float k1 = static_cast<float>(.45 + static_cast<double>(random.Unit()) * .4);
  const float k2 = static_cast<float>(.45 + static_cast<double>(random.Unit()) * .4);
  const float width = static_cast<float>(side * static_cast<double>(k1) * static_cast<double>(k1));
  const float height = static_cast<float>(side * static_cast<double>(k2) * static_cast<double>(k2));
  const double place = static_cast<double>(random.Unit());
  if (upright) {
    return {(side - static_cast<double>(width)) * place, 0, static_cast<double>(width), side};
  }
  return {0, (side - static_cast<double>(height)) * place, side, static_cast<double>(height)};
}

}  // namespace

GeneratedArt GenerateBackground(RandomStream& random) {
  GeneratedArt art;
  art.size_px = kBackgroundSizePx;
  AddBlock(random, {0, 0, kBackgroundSizePx, kBackgroundSizePx}, kBackgroundDepth,
           kBackgroundBlotches, art);
  return art;
}

GeneratedArt GenerateBlock(RandomStream& random) {
  GeneratedArt art;
  art.size_px = kSpriteSizePx;
  AddBlock(random, {0, 0, kSpriteSizePx, kSpriteSizePx}, 0, kSpriteBlotches, art);
  return art;
}

GeneratedArt GenerateFigure(RandomStream& random) {
  GeneratedArt art;
  art.size_px = kSpriteSizePx;
  art.transparent = true;
  const Palette palette = DrawPalette(random);
  const bool upright_first = random.Coin();
  const int32_t first_bars = random.Int(3) / 2 + 1;
  const int32_t second_bars = random.Int(3) / 2 + 1;
  for (int32_t i = 0; i < first_bars + second_bars; ++i) {
    const bool upright = i < first_bars ? upright_first : !upright_first;
    const Rect bar = DrawBar(random, upright);
    AddShape(random, bar, palette, art);
  }
  const int32_t blotches = random.Int(1, 5);
  for (int32_t i = 0; i < blotches; ++i) {
    const Rect part = DrawPart(random, {0, 0, kSpriteSizePx, kSpriteSizePx},
                               {kFigureBlotchMin, kFigureBlotchMax});
    AddShape(random, part, palette, art);
  }
  return art;
}

}  // namespace procgen
