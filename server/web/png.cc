#include "server/web/png.h"

#include <png.h>

namespace procgen::web {

std::string PngOf(absl::string_view rgb, int32_t width_px, int32_t height_px) {
  png_image image = {};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(width_px);
  image.height = static_cast<png_uint_32>(height_px);
  image.format = PNG_FORMAT_RGB;
  image.flags = PNG_IMAGE_FLAG_FAST;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::string file(size, '\0');
  const bool is_written =
      png_image_write_to_memory(&image, file.data(), &size, 0, rgb.data(), 0, nullptr) != 0;
  file.resize(is_written ? size : 0);
  return file;
}

}  // namespace procgen::web
