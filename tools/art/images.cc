#include "tools/art/images.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "png.h"

namespace procgen {

absl::Status WritePng(const Image& image, const std::string& path) {
  png_image file = {};
  file.version = PNG_IMAGE_VERSION;
  file.width = static_cast<png_uint_32>(image.width());
  file.height = static_cast<png_uint_32>(image.height());
  file.format = PNG_FORMAT_RGBA;
  if (png_image_write_to_file(&file, path.c_str(), 0, image.Row(0), 0, nullptr) == 0) {
    return absl::InvalidArgumentError(absl::StrCat("cannot write ", path, ": ", file.message));
  }
  return absl::OkStatus();
}

Image Enlarged(const Image& image, int factor) {
  Image enlarged(image.width() * factor, image.height() * factor);
  for (int y = 0; y < enlarged.height(); ++y) {
    for (int x = 0; x < enlarged.width(); ++x) {
      enlarged.At(x, y) = image.At(x / factor, y / factor);
    }
  }
  return enlarged;
}

void Paste(const Image& source, int left, int top, Image* target) {
  for (int y = 0; y < source.height(); ++y) {
    std::copy_n(source.Row(y), source.width(), target->Row(top + y) + left);
  }
}

}  // namespace procgen
