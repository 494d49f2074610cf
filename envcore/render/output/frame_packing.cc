#include "envcore/render/output/frame_packing.h"

#include <cstddef>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace procgen {
namespace {

#if defined(__x86_64__)

// Eight pixels fill a 32-byte register; packed, they fill its lower 24 bytes.
constexpr size_t kPixelsAtOnce = 8;
constexpr size_t kPackedBytes = 3 * kPixelsAtOnce;

__attribute__((target("avx2"))) __m256i PackEight(const Rgba* pixels) {
  const __m256i order = _mm256_setr_epi8(0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14, -1, -1, -1, -1, 0,
                                         1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14, -1, -1, -1, -1);
  const __m256i together = _mm256_setr_epi32(0, 1, 2, 4, 5, 6, 3, 7);
  const __m256i eight = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(pixels));
  return _mm256_permutevar8x32_epi32(_mm256_shuffle_epi8(eight, order), together);
}

__attribute__((target("avx2"))) __m256i UnpackEight(__m256i packed) {
  const __m256i apart = _mm256_setr_epi32(0, 1, 2, 6, 3, 4, 5, 7);
  const __m256i order = _mm256_setr_epi8(0, 1, 2, -1, 3, 4, 5, -1, 6, 7, 8, -1, 9, 10, 11, -1, 0, 1,
                                         2, -1, 3, 4, 5, -1, 6, 7, 8, -1, 9, 10, 11, -1);
  const __m256i opaque = _mm256_set1_epi32(static_cast<int>(0xff000000U));
  const __m256i pixels = _mm256_shuffle_epi8(_mm256_permutevar8x32_epi32(packed, apart), order);
  return _mm256_or_si256(pixels, opaque);
}

// Both return the number of pixels done. All groups of eight but the last load or store a whole
// register, which overlaps the next group.
__attribute__((target("avx2"))) size_t PackByEights(const Rgba* pixels, size_t count,
                                                    uint8_t* rgb) {
  size_t i = 0;
  for (; i + 2 * kPixelsAtOnce <= count; i += kPixelsAtOnce, rgb += kPackedBytes) {
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(rgb), PackEight(pixels + i));
  }
  if (i + kPixelsAtOnce <= count) {
    const __m256i packed = PackEight(pixels + i);
    _mm_storeu_si128(reinterpret_cast<__m128i*>(rgb), _mm256_castsi256_si128(packed));
    _mm_storel_epi64(reinterpret_cast<__m128i*>(rgb + sizeof(__m128i)),
                     _mm256_extracti128_si256(packed, 1));
    i += kPixelsAtOnce;
  }
  return i;
}

__attribute__((target("avx2"))) size_t UnpackByEights(const uint8_t* rgb, size_t count,
                                                      Rgba* pixels) {
  const auto store = [](Rgba * to, __m256i packed) __attribute__((target("avx2"))) {
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), UnpackEight(packed));
  };
  size_t i = 0;
  for (; i + 2 * kPixelsAtOnce <= count; i += kPixelsAtOnce, rgb += kPackedBytes) {
    store(pixels + i, _mm256_loadu_si256(reinterpret_cast<const __m256i*>(rgb)));
  }
  if (i + kPixelsAtOnce <= count) {
    const auto* bytes = reinterpret_cast<const __m128i*>(rgb);
    store(pixels + i, _mm256_set_m128i(_mm_loadl_epi64(bytes + 1), _mm_loadu_si128(bytes)));
    i += kPixelsAtOnce;
  }
  return i;
}

#endif

// SIMD if the CPU has it. Both return the number of pixels done.
size_t PackMany([[maybe_unused]] const Rgba* pixels, [[maybe_unused]] size_t count,
                [[maybe_unused]] uint8_t* rgb) {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) {
    return PackByEights(pixels, count, rgb);
  }
#endif
  return 0;
}

size_t UnpackMany([[maybe_unused]] const uint8_t* rgb, [[maybe_unused]] size_t count,
                  [[maybe_unused]] Rgba* pixels) {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) {
    return UnpackByEights(rgb, count, pixels);
  }
#endif
  return 0;
}

void PackRgb(absl::Span<const Rgba> pixels, uint8_t* rgb) {
  const size_t count = pixels.size();
  for (size_t i = PackMany(pixels.data(), count, rgb); i < count; ++i) {
    rgb[3 * i] = pixels[i].red;
    rgb[3 * i + 1] = pixels[i].green;
    rgb[3 * i + 2] = pixels[i].blue;
  }
}

// The next two are simple loops, which compilers vectorize.
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
