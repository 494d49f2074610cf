#ifndef SERVER_ENCODING_PNG_H_
#define SERVER_ENCODING_PNG_H_

#include <cstdint>
#include <string>

#include "absl/types/span.h"

namespace procgen {

// Encodes an image as PNG, for speed rather than size. `pixels`: uint8 [size_px, size_px, 3], red,
// green, blue, top row first. REQUIRES: size_px > 0.
std::string PngOf(absl::Span<const uint8_t> pixels, int32_t size_px);

// Maximum size of the PNG of such an image, in bytes.
int64_t PngBytesMax(int32_t size_px);

}  // namespace procgen

#endif  // SERVER_ENCODING_PNG_H_
