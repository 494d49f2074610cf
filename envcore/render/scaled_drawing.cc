#include "envcore/render/scaled_drawing.h"

#include <algorithm>
#include <cstring>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace procgen {
namespace {

// Rows are short: four pixels at a time cost less than a call of memcpy.
void CopyPixels(const Rgba* from, int count, Rgba* to) {
  for (; count >= 4; count -= 4, from += 4, to += 4) {
    std::memcpy(to, from, 4 * sizeof(Rgba));
  }
  for (; count > 0; --count) {
    *to++ = *from++;
  }
}

#if defined(__SSE2__)

// Lays four pixels over four others.
void LayFour(const Rgba* from, Rgba* to) {
  const __m128i zero = _mm_setzero_si128();
  const __m128i source = _mm_loadu_si128(reinterpret_cast<const __m128i*>(from));
  const __m128i below = _mm_loadu_si128(reinterpret_cast<const __m128i*>(to));
  // What is left of each pixel below, in both halves of its 32 bits.
  const __m128i rest = _mm_sub_epi32(_mm_set1_epi32(255), _mm_srli_epi32(source, 24));
  const __m128i rests = _mm_or_si128(rest, _mm_slli_epi32(rest, 16));
  const auto mul = [](__m128i channels, __m128i factors) {
    const __m128i t = _mm_mullo_epi16(channels, factors);
    const __m128i sum = _mm_add_epi16(_mm_add_epi16(t, _mm_srli_epi16(t, 8)), _mm_set1_epi16(128));
    return _mm_srli_epi16(sum, 8);
  };
  const __m128i low = mul(_mm_unpacklo_epi8(below, zero), _mm_unpacklo_epi32(rests, rests));
  const __m128i high = mul(_mm_unpackhi_epi8(below, zero), _mm_unpackhi_epi32(rests, rests));
  _mm_storeu_si128(reinterpret_cast<__m128i*>(to),
                   _mm_add_epi8(source, _mm_packus_epi16(low, high)));
}

#else

void LayFour(const Rgba* from, Rgba* to) {
  for (int i = 0; i < 4; ++i) {
    LayOver(from[i], to[i]);
  }
}

#endif

void LayPixels(const Rgba* from, int count, Rgba* to) {
  for (; count >= 4; count -= 4, from += 4, to += 4) {
    LayFour(from, to);
  }
  for (; count > 0; --count, ++from, ++to) {
    LayOver(*from, *to);
  }
}

// Calls `draw(source, count, pixel)` for each row of the picture that is in the frame.
template <typename Draw>
void ForEachRow(const Image& image, int left, int top, const Frame& frame, Draw draw) {
  const int first = std::max(left, 0);
  const int count = std::min(left + image.width(), frame.side_px) - first;
  const int end = std::min(top + image.height(), frame.side_px);
  if (count <= 0) {
    return;
  }
  for (int y = std::max(top, 0); y < end; ++y) {
    draw(image.Row(y - top) + (first - left), count, frame.At(first, y));
  }
}

}  // namespace

void DrawScaled(const ScaledPicture& picture, int left, int top, const Frame& frame) {
  if (picture.opaque) {
    ForEachRow(picture.image, left, top, frame, CopyPixels);
  } else {
    ForEachRow(picture.image, left, top, frame, LayPixels);
  }
}

void DrawScaledShown(const ScaledPicture& picture, int left, int top, const HiddenPixels* hidden,
                     const Frame& frame) {
  if (hidden == nullptr) {
    ForEachRow(picture.image, left, top, frame, CopyPixels);
    return;
  }
  const Image& image = picture.image;
  const int end = std::min(top + image.height(), frame.side_px);
  for (int y = std::max(top, 0); y < end; ++y) {
    const Rgba* source = image.Row(y - top);
    hidden->ForEachShown(
        y, left, std::min(left + image.width(), frame.side_px), [&](int from, int to) {
          std::copy(source + (from - left), source + (to - left), frame.At(from, y));
        });
  }
}

void DrawScaledFaded(const ScaledPicture& picture, int left, int top, uint32_t opacity,
                     const Frame& frame) {
  ForEachRow(picture.image, left, top, frame, [opacity](const Rgba* from, int count, Rgba* to) {
    for (int i = 0; i < count; ++i) {
      LayOver(Mul(from[i], opacity), to[i]);
    }
  });
}

}  // namespace procgen
