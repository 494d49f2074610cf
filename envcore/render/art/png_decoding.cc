#include "envcore/render/art/png_decoding.h"

#include <cstdint>
#include <memory>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "envcore/status/status.h"
#include "zlib.h"

// Compiled here: Debian's archive of it is for programs only. 8-bit PNGs in memory are all there
// is. Not analysed: without memory for 8 bits, stb_image leaks an image of 16.
#ifndef __clang_analyzer__
#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#endif
#define STBI_ONLY_PNG
#define STBI_NO_STDIO
#define STBI_MAX_DIMENSIONS 8192  // kPngSizePxMax
#include "stb/stb_image.h"

namespace procgen {
namespace {

static_assert(STBI_MAX_DIMENSIONS == kPngSizePxMax);

const uint8_t* Unsigned(absl::string_view bytes) {
  return reinterpret_cast<const uint8_t*>(bytes.data());
}

uint32_t BigEndian(absl::string_view bytes) {
  const uint8_t* p = Unsigned(bytes);
  return uint32_t{p[0]} << 24 | uint32_t{p[1]} << 16 | uint32_t{p[2]} << 8 | uint32_t{p[3]};
}

// A chunk of a PNG file.
struct Chunk {
  absl::string_view type;  // four letters
  absl::string_view content;
};

// Removes the next chunk from `rest`. Returns false if it is truncated or damaged.
bool TakeChunk(absl::string_view* rest, Chunk* chunk) {
  constexpr size_t kFrameBytes = 12;  // length, type, checksum
  if (rest->size() < kFrameBytes || BigEndian(*rest) > rest->size() - kFrameBytes) {
    return false;
  }
  const size_t length = BigEndian(*rest);
  const absl::string_view checked = rest->substr(4, 4 + length);
  const uint32_t checksum = BigEndian(rest->substr(8 + length));
  rest->remove_prefix(kFrameBytes + length);
  *chunk = {checked.substr(0, 4), checked.substr(4)};
  return crc32(0, Unsigned(checked), static_cast<uInt>(checked.size())) == checksum;
}

// `pixels`: uint8 [height, width, 4].
Image ToImage(const uint8_t* pixels, int width, int height, AlphaUse alpha_use) {
  Image image(width, height);
  const uint8_t* p = pixels;
  for (int y = 0; y < height; ++y) {
    Rgba* row = image.Row(y);
    for (int x = 0; x < width; ++x, p += 4) {
      const Rgba plain = {p[0], p[1], p[2], p[3]};
      row[x] = alpha_use == AlphaUse::kPremultiplied ? Premultiplied(plain)
                                                     : Rgba{p[0], p[1], p[2], 255};
    }
  }
  return image;
}

}  // namespace

StatusOr<Image> DecodePng(absl::string_view bytes, AlphaUse alpha_use) {
  int width = 0;
  int height = 0;
  const std::unique_ptr<stbi_uc, decltype(&stbi_image_free)> pixels(
      stbi_load_from_memory(Unsigned(bytes), static_cast<int>(bytes.size()), &width, &height,
                            nullptr, STBI_rgb_alpha),
      stbi_image_free);
  if (pixels == nullptr) {
    return InvalidArgumentError(absl::StrCat("is not a valid PNG: ", stbi_failure_reason()));
  }
  return ToImage(pixels.get(), width, height, alpha_use);
}

StatusOr<PngSize> CheckPng(absl::string_view bytes) {
  constexpr absl::string_view kSignature = "\x89PNG\r\n\x1a\n";
  if (bytes.substr(0, kSignature.size()) != kSignature) {
    return InvalidArgumentError("is not a PNG file");
  }
  absl::string_view rest = bytes.substr(kSignature.size());
  Chunk chunk;
  if (!TakeChunk(&rest, &chunk) || chunk.type != "IHDR" || chunk.content.size() != 13) {
    return InvalidArgumentError("is not a valid PNG: the header is damaged");
  }
  const uint32_t width = BigEndian(chunk.content);
  const uint32_t height = BigEndian(chunk.content.substr(4));
  if (width < 1 || width > kPngSizePxMax || height < 1 || height > kPngSizePxMax) {
    return InvalidArgumentError(absl::StrCat(
        "is ", width, " x ", height, " pixels, each side must be in [1, ", kPngSizePxMax, "]"));
  }
  while (chunk.type != "IEND") {
    if (!TakeChunk(&rest, &chunk)) {
      return InvalidArgumentError("is not a valid PNG: damaged or truncated");
    }
  }
  return PngSize{static_cast<int>(width), static_cast<int>(height)};
}

}  // namespace procgen
