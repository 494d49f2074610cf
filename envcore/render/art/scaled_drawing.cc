#include "envcore/render/art/scaled_drawing.h"

#include <algorithm>
#include <cstdint>
#include <cstring>

#if defined(__SSE2__)
#include <emmintrin.h>
#else
#include <array>
#endif

namespace procgen {
namespace {

constexpr uint32_t kOpaque = 255;

// Copies four pixels at a time; the last four may overlap those before. Rows are short, so this
// costs less than calling memcpy.
void CopyPixels(const Rgba* from, int count, Rgba* to) {
  if (count < 4) {
    for (; count > 0; --count) {
      *to++ = *from++;
    }
    return;
  }
  const int last = count - 4;
  for (int i = 0; i < last; i += 4) {
    std::memcpy(to + i, from + i, 4 * sizeof(Rgba));
  }
  std::memcpy(to + last, from + last, 4 * sizeof(Rgba));
}

#if defined(__SSE2__)

// Four pixels that are processed at once.
class FourPixels {
 public:
  explicit FourPixels(const Rgba* from)
      : bytes_(_mm_loadu_si128(reinterpret_cast<const __m128i*>(from))) {}

  void Mul(uint32_t factor) {
    const __m128i factors = _mm_set1_epi16(static_cast<int16_t>(factor));
    bytes_ = Products(bytes_, factors, factors);
  }

  // Blends them over the pixels at `below`.
  void BlendOver(const Rgba* below) {
    const __m128i pixels = _mm_loadu_si128(reinterpret_cast<const __m128i*>(below));
    // The remaining weight of each pixel below, in both halves of its 32 bits.
    const __m128i rest = _mm_sub_epi32(_mm_set1_epi32(255), _mm_srli_epi32(bytes_, 24));
    const __m128i rests = _mm_or_si128(rest, _mm_slli_epi32(rest, 16));
    const __m128i left =
        Products(pixels, _mm_unpacklo_epi32(rests, rests), _mm_unpackhi_epi32(rests, rests));
    bytes_ = _mm_add_epi8(bytes_, left);
  }

  void Store(Rgba* to) const { _mm_storeu_si128(reinterpret_cast<__m128i*>(to), bytes_); }

 private:
  // Like procgen::Mul, with a 16-bit factor for each channel.
  static __m128i Products(__m128i pixels, __m128i low_factors, __m128i high_factors) {
    const __m128i zero = _mm_setzero_si128();
    const auto mul = [](__m128i channels, __m128i factors) {
      const __m128i t = _mm_mullo_epi16(channels, factors);
      const __m128i sum =
          _mm_add_epi16(_mm_add_epi16(t, _mm_srli_epi16(t, 8)), _mm_set1_epi16(128));
      return _mm_srli_epi16(sum, 8);
    };
    return _mm_packus_epi16(mul(_mm_unpacklo_epi8(pixels, zero), low_factors),
                            mul(_mm_unpackhi_epi8(pixels, zero), high_factors));
  }

  __m128i bytes_;
};

#else

class FourPixels {
 public:
  explicit FourPixels(const Rgba* from) { std::copy(from, from + 4, pixels_.begin()); }

  void Mul(uint32_t factor) {
    for (Rgba& pixel : pixels_) {
      pixel = procgen::Mul(pixel, factor);
    }
  }

  void BlendOver(const Rgba* below) {
    for (Rgba& pixel : pixels_) {
      Rgba result = *below++;
      procgen::BlendOver(pixel, result);
      pixel = result;
    }
  }

  void Store(Rgba* to) const { std::copy(pixels_.begin(), pixels_.end(), to); }

 private:
  std::array<Rgba, 4> pixels_;
};

#endif

FourPixels LaidOver(const Rgba* from, uint32_t opacity, const Rgba* below) {
  FourPixels four(from);
  if (opacity != kOpaque) {
    four.Mul(opacity);
  }
  four.BlendOver(below);
  return four;
}

void LayPixels(const Rgba* from, int count, uint32_t opacity, Rgba* to) {
  if (count < 4) {
    for (; count > 0; --count, ++from, ++to) {
      BlendOver(Mul(*from, opacity), *to);
    }
    return;
  }
  // The last four pixels may overlap those before, so they are blended before those are written.
  const int last = count - 4;
  const FourPixels last_four = LaidOver(from + last, opacity, to + last);
  for (int i = 0; i < last; i += 4) {
    LaidOver(from + i, opacity, to + i).Store(to + i);
  }
  last_four.Store(to + last);
}

// Calls `draw(source, pixel)` for each row of `box`, with its first pixels. The image's top left is
// at (left, top). REQUIRES: the box is inside the image and the frame.
template <typename Draw>
void ForEachRow(const Image& image, int left, int top, const PixelBox& box, const Frame& frame,
                Draw draw) {
  const Rgba* source = image.Row(box.top - top) + (box.left - left);
  Rgba* pixel = frame.At(box.left, box.top);
  const int source_step = image.width();
  const int step = frame.size_px;
  for (int rows = box.height(); rows > 0; --rows, source += source_step, pixel += step) {
    draw(source, pixel);
  }
}

// Most sprites and cells are small: two copies of four pixels make a row.
void CopyRows(const Image& image, int left, int top, const PixelBox& box, const Frame& frame) {
  const int count = box.width();
  if (count >= 4 && count <= 8) {
    const int last = count - 4;
    ForEachRow(image, left, top, box, frame, [last](const Rgba* from, Rgba* to) {
      std::memcpy(to, from, 4 * sizeof(Rgba));
      std::memcpy(to + last, from + last, 4 * sizeof(Rgba));
    });
    return;
  }
  ForEachRow(image, left, top, box, frame,
             [count](const Rgba* from, Rgba* to) { CopyPixels(from, count, to); });
}

}  // namespace

void DrawScaled(const ScaledImage& picture, int left, int top, uint32_t opacity,
                const Frame& frame) {
  const Image& image = picture.image;
  const PixelBox box = frame.Cut({left, top, left + image.width(), top + image.height()});
  if (box.IsEmpty()) {
    return;
  }
  if (picture.opaque && opacity == kOpaque) {
    CopyRows(image, left, top, box, frame);
    return;
  }
  const int count = box.width();
  ForEachRow(image, left, top, box, frame,
             [count, opacity](const Rgba* from, Rgba* to) { LayPixels(from, count, opacity, to); });
}

void DrawScaledBackdrop(const Image& image, const PixelBox& box, BackdropPixels* pixels,
                        const Frame& frame) {
  ForEachRunToDraw(frame.Cut(box), pixels, [&](int row, int first, int end) {
    CopyPixels(image.Row(row - box.top) + (first - box.left), end - first, frame.At(first, row));
  });
}

}  // namespace procgen
