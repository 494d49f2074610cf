#include "envcore/render/frame_packing.h"

#include <cstddef>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace procgen {
namespace {

void PackOneByOne(const Rgba* pixels, size_t count, uint8_t* rgb) {
  for (size_t i = 0; i < count; ++i) {
    rgb[3 * i] = pixels[i].red;
    rgb[3 * i + 1] = pixels[i].green;
    rgb[3 * i + 2] = pixels[i].blue;
  }
}

#if defined(__x86_64__)

constexpr size_t kPixelsAtOnce = 16;

// Four pixels as twelve bytes, and four that are 0.
__attribute__((target("ssse3"))) __m128i LoadFour(const Rgba* pixels) {
  const __m128i order = _mm_setr_epi8(0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14, -1, -1, -1, -1);
  return _mm_shuffle_epi8(_mm_loadu_si128(reinterpret_cast<const __m128i*>(pixels)), order);
}

__attribute__((target("ssse3"))) void PackBySixteens(const Rgba* pixels, size_t count,
                                                     uint8_t* rgb) {
  size_t i = 0;
  for (; i + kPixelsAtOnce <= count; i += kPixelsAtOnce) {
    const __m128i a = LoadFour(pixels + i);
    const __m128i b = LoadFour(pixels + i + 4);
    const __m128i c = LoadFour(pixels + i + 8);
    const __m128i d = LoadFour(pixels + i + 12);
    auto* out = reinterpret_cast<__m128i*>(rgb + 3 * i);
    _mm_storeu_si128(out, _mm_or_si128(a, _mm_slli_si128(b, 12)));
    _mm_storeu_si128(out + 1, _mm_or_si128(_mm_srli_si128(b, 4), _mm_slli_si128(c, 8)));
    _mm_storeu_si128(out + 2, _mm_or_si128(_mm_srli_si128(c, 8), _mm_slli_si128(d, 4)));
  }
  PackOneByOne(pixels + i, count - i, rgb + 3 * i);
}

// Four pixels at a time, of sixteen bytes of which twelve are theirs. Returns how many it has done:
// it reads nothing beyond the last pixel.
__attribute__((target("ssse3"))) size_t UnpackByFours(const uint8_t* rgb, size_t count,
                                                      Rgba* pixels) {
  const __m128i order = _mm_setr_epi8(0, 1, 2, -1, 3, 4, 5, -1, 6, 7, 8, -1, 9, 10, 11, -1);
  const __m128i opaque = _mm_set1_epi32(static_cast<int>(0xff000000U));
  size_t i = 0;
  for (; 3 * i + sizeof(__m128i) <= 3 * count; i += 4) {
    const __m128i four = _mm_loadu_si128(reinterpret_cast<const __m128i*>(rgb + 3 * i));
    _mm_storeu_si128(reinterpret_cast<__m128i*>(pixels + i),
                     _mm_or_si128(_mm_shuffle_epi8(four, order), opaque));
  }
  return i;
}

#endif

size_t UnpackMany([[maybe_unused]] const uint8_t* rgb, [[maybe_unused]] size_t count,
                  [[maybe_unused]] Rgba* pixels) {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("ssse3")) {
    return UnpackByFours(rgb, count, pixels);
  }
#endif
  return 0;
}

void PackRgb(absl::Span<const Rgba> pixels, uint8_t* rgb) {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("ssse3")) {
    PackBySixteens(pixels.data(), pixels.size(), rgb);
    return;
  }
#endif
  PackOneByOne(pixels.data(), pixels.size(), rgb);
}

// The next two are simple loops, which compilers turn into vectors themselves.
void PackPlanes(absl::Span<const Rgba> pixels, uint8_t* planes) {
  const size_t count = pixels.size();
  for (size_t i = 0; i < count; ++i) {
    planes[i] = pixels[i].red;
  }
  for (size_t i = 0; i < count; ++i) {
    planes[count + i] = pixels[i].green;
  }
  for (size_t i = 0; i < count; ++i) {
    planes[2 * count + i] = pixels[i].blue;
  }
}

void PackGrey(absl::Span<const Rgba> pixels, uint8_t* grey) {
  for (size_t i = 0; i < pixels.size(); ++i) {
    const Rgba& pixel = pixels[i];
    const uint32_t luma = 77U * pixel.red + 150U * pixel.green + 29U * pixel.blue;
    grey[i] = static_cast<uint8_t>((luma + 128U) >> 8);
  }
}

}  // namespace

void PackFrame(absl::Span<const Rgba> pixels, Color color, Layout layout,
               absl::Span<uint8_t> frame) {
  if (color == Color::kGrayscale) {
    PackGrey(pixels, frame.data());
  } else if (layout == Layout::kChw) {
    PackPlanes(pixels, frame.data());
  } else {
    PackRgb(pixels, frame.data());
  }
}

void UnpackRgb(absl::Span<const uint8_t> rgb, absl::Span<Rgba> pixels) {
  for (size_t i = UnpackMany(rgb.data(), pixels.size(), pixels.data()); i < pixels.size(); ++i) {
    pixels[i] = {rgb[3 * i], rgb[3 * i + 1], rgb[3 * i + 2], 255};
  }
}

}  // namespace procgen
