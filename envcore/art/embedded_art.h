#ifndef ENVCORE_ART_EMBEDDED_ART_H_
#define ENVCORE_ART_EMBEDDED_ART_H_

#include <vector>

#include "absl/strings/string_view.h"

namespace procgen {

// A picture that was built into the program.
struct EmbeddedFile {
  absl::string_view name;  // "coinrun/coin_0", "platform_00"
  absl::string_view png;   // a PNG file's bytes; both live as long as the program
};

// All of them, in the order of the manifests.
std::vector<EmbeddedFile> EmbeddedArt();

}  // namespace procgen

#endif  // ENVCORE_ART_EMBEDDED_ART_H_
