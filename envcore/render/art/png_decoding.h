#ifndef ENVCORE_RENDER_ART_PNG_DECODING_H_
#define ENVCORE_RENDER_ART_PNG_DECODING_H_

#include "absl/strings/string_view.h"
#include "envcore/render/raster/image.h"
#include "envcore/status/status.h"

namespace procgen {

// How the alpha channel of a file is used.
enum class AlphaUse {
  kPremultiplied,  // sprites
  kIgnored,        // backgrounds: colors unchanged, every pixel opaque
};

// Decodes a PNG file of any type to 8-bit channels. Color profiles and gamma are ignored. Errors:
// INVALID_ARGUMENT: the bytes are not a valid PNG, or a side is above kPngSizePxMax.
StatusOr<Image> DecodePng(absl::string_view bytes, AlphaUse alpha_use);

inline constexpr int kPngSizePxMax = 8192;

struct PngSize {
  int width_px = 0;
  int height_px = 0;
};

// Reads the size of a PNG file and checks signature, chunks and checksums. Costs a small fraction
// of decoding. Errors: INVALID_ARGUMENT, as DecodePng. Bytes that pass can be decoded, unless an
// encoder wrote invalid data with valid checksums.
StatusOr<PngSize> CheckPng(absl::string_view bytes);

}  // namespace procgen

#endif  // ENVCORE_RENDER_ART_PNG_DECODING_H_
