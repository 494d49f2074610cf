#ifndef ENVCORE_RENDER_ART_PNG_DECODING_H_
#define ENVCORE_RENDER_ART_PNG_DECODING_H_

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "envcore/render/raster/image.h"

namespace procgen {

// What becomes of a file's transparency.
enum class AlphaUse {
  kPremultiplied,  // sprites
  kIgnored,        // backgrounds: colours as they are, every pixel opaque
};

// Decodes a PNG file of any kind to 8-bit channels as they are stored (colour profiles and gamma
// are ignored). Errors: INVALID_ARGUMENT the bytes are no PNG or broken, or a side is above
// kPngSizePxMax.
absl::StatusOr<Image> DecodePng(absl::string_view bytes, AlphaUse alpha_use);

inline constexpr int kPngSizePxMax = 8192;

struct PngSize {
  int width_px = 0;
  int height_px = 0;
};

// Reads the size of a PNG file and checks that it is whole: signature, parts and their checksums.
// Costs a small part of what decoding does. Errors: INVALID_ARGUMENT as DecodePng; bytes that pass
// can be decoded, unless a program wrote nonsense with right checksums.
absl::StatusOr<PngSize> CheckPng(absl::string_view bytes);

}  // namespace procgen

#endif  // ENVCORE_RENDER_ART_PNG_DECODING_H_
