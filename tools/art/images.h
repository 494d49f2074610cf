#ifndef TOOLS_ART_IMAGES_H_
#define TOOLS_ART_IMAGES_H_

#include <string>

#include "absl/status/status.h"
#include "envcore/render/raster/image.h"

namespace procgen {

// Writes an image of opaque pixels as a PNG file. Errors: INVALID_ARGUMENT it cannot be written.
absl::Status WritePng(const Image& image, const std::string& path);

// `image` with each pixel as a square of factor x factor pixels.
Image Enlarged(const Image& image, int factor);

// Copies `source` into `target`, its top left corner at (left, top).
// REQUIRES: it fits.
void Paste(const Image& source, int left, int top, Image* target);

}  // namespace procgen

#endif  // TOOLS_ART_IMAGES_H_
