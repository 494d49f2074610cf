#ifndef TOOLS_ART_IMAGES_H_
#define TOOLS_ART_IMAGES_H_

#include <string>

#include "absl/status/status.h"
#include "envcore/render/raster/image.h"

namespace procgen {

// Writes an image of opaque pixels as a PNG file. Errors: INVALID_ARGUMENT: the file cannot be
// written.
absl::Status WritePng(const Image& image, const std::string& path);

// Returns `image` with each pixel enlarged to factor x factor pixels.
Image Enlarged(const Image& image, int factor);

// Copies `source` into `target` with its top left corner at (left, top). REQUIRES: it fits.
void Paste(const Image& source, int left, int top, Image* target);

}  // namespace procgen

#endif  // TOOLS_ART_IMAGES_H_
