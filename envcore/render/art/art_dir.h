#ifndef ENVCORE_RENDER_ART_ART_DIR_H_
#define ENVCORE_RENDER_ART_ART_DIR_H_

#include <memory>
#include <string>

#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "envcore/render/art/art_pack.h"
#include "envcore/status/status.h"

namespace procgen {

// An image that an art folder must contain.
struct RequiredImage {
  absl::string_view path;  // relative to the folder: "misc_assets/coin.png"
  // The required size, because entity sizes follow from it; 0: any size.
  int width_px = 0;
  int height_px = 0;
};

// Reads the required images of a folder in the layout of Procgen 0.10.7. All files are read and
// checked here, so the folder is not needed afterwards. Each image is decoded for drawing on first
// use.
// Errors: NOT_FOUND: the folder or a file does not exist. INVALID_ARGUMENT: a file cannot be read,
// is not a valid PNG, has another size, or exceeds the pixel limit of all images together. The
// message names the folder, the first few files with their errors, and the number of further files.
StatusOr<std::shared_ptr<const ArtPack>> ReadArtDir(const std::string& folder,
                                                    absl::Span<const RequiredImage> required);

}  // namespace procgen

#endif  // ENVCORE_RENDER_ART_ART_DIR_H_
