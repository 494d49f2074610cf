#ifndef SERVER_WEB_PNG_H_
#define SERVER_WEB_PNG_H_

#include <cstdint>
#include <string>

#include "absl/strings/string_view.h"

namespace procgen::web {

// A PNG file of a picture: `rgb` is uint8 [height_px, width_px, 3], top row first.
std::string PngOf(absl::string_view rgb, int32_t width_px, int32_t height_px);

}  // namespace procgen::web

#endif  // SERVER_WEB_PNG_H_
