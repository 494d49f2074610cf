#ifndef ENVCORE_RENDER_ART_ART_FOLDER_H_
#define ENVCORE_RENDER_ART_ART_FOLDER_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "envcore/render/art/art_pack.h"

namespace procgen {

// A picture that an art folder must have.
struct RequiredImage {
  absl::string_view path;  // in the folder: "misc_assets/coin.png"
  // What its size must be, as sizes in worlds follow from it; 0: any.
  int width_px = 0;
  int height_px = 0;
};

// Reads the required pictures of a folder in the layout of Procgen 0.10.7. All bytes are read here,
// and decoded once to check them, so that the folder is not needed afterwards; pictures that are
// shown are decoded when first asked for. Errors: NOT_FOUND there is no such folder, or a file is
// missing; INVALID_ARGUMENT a file cannot be read, is no sound PNG, has another size, or more
// pixels than all pictures together may have. One message names the folder, the first few files
// with what is wrong with each, and how many more there are.
absl::StatusOr<std::shared_ptr<const ArtPack>> ReadArtFolder(
    const std::string& folder, absl::Span<const RequiredImage> required);

}  // namespace procgen

#endif  // ENVCORE_RENDER_ART_ART_FOLDER_H_
