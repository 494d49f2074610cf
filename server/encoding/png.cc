#include "server/encoding/png.h"

#include <png.h>

#include "server/encoding/check.h"

namespace procgen {
namespace {

png_image HeaderOf(int32_t size_px) {
  png_image image = {};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(size_px);
  image.height = static_cast<png_uint_32>(size_px);
  image.format = PNG_FORMAT_RGB;
  image.flags = PNG_IMAGE_FLAG_FAST;
  return image;
}

}  // namespace

std::string PngOf(absl::Span<const uint8_t> pixels, int32_t size_px) {
  png_image image = HeaderOf(size_px);
  std::string file(static_cast<size_t>(PngBytesMax(size_px)), '\0');
  png_alloc_size_t size = file.size();
  const int written =
      png_image_write_to_memory(&image, file.data(), &size, 0, pixels.data(), 0, nullptr);
  Check(written != 0, image.message);
  file.resize(size);
  return file;
}

int64_t PngBytesMax(int32_t size_px) {
  const png_image image = HeaderOf(size_px);
  return static_cast<int64_t>(PNG_IMAGE_PNG_SIZE_MAX(image));
}

}  // namespace procgen
