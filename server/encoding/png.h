#ifndef SERVER_ENCODING_PNG_H_
#define SERVER_ENCODING_PNG_H_

#include <cstdint>
#include <string>

#include "absl/types/span.h"

namespace procgen {

// A PNG file of a picture; quickly made rather than small. `pixels`: uint8 [size_px, size_px, 3],
// red, green, blue, top row first. REQUIRES: size_px > 0.
std::string PngOf(absl::Span<const uint8_t> pixels, int32_t size_px);

// No PNG file of such a picture has more bytes.
int64_t PngBytesMax(int32_t size_px);

}  // namespace procgen

#endif  // SERVER_ENCODING_PNG_H_
