#ifndef ENVCORE_ART_EMBEDDED_ART_H_
#define ENVCORE_ART_EMBEDDED_ART_H_

#include <vector>

#include "absl/strings/string_view.h"

namespace procgen {

// An image that is linked into the program.
struct EmbeddedFile {
  absl::string_view name;  // "coinrun/coin_0", "platform_00"
  absl::string_view png;   // content of a PNG file; both live as long as the program
};

// All embedded images, in the order of the manifests.
std::vector<EmbeddedFile> EmbeddedArt();

}  // namespace procgen

#endif  // ENVCORE_ART_EMBEDDED_ART_H_
