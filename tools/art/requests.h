#ifndef TOOLS_ART_REQUESTS_H_
#define TOOLS_ART_REQUESTS_H_

#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "envcore/games/game_catalog.h"
#include "envcore/pool/shared_art.h"

namespace procgen {

// What a program is asked to draw.
struct DrawingRequest {
  std::vector<const GameSpec*> games;
  std::shared_ptr<const SharedArt> art;
};

// The games of these names, or all if there are none, with the art of a folder in the layout
// of Procgen 0.10.7, or the built-in art if `art_dir` is empty. Errors: INVALID_ARGUMENT a name
// that no game has (the message says which there are); for the folder as SharedArt::LoadFolder.
absl::StatusOr<DrawingRequest> MakeDrawingRequest(const std::vector<std::string>& game_names,
                                                  const std::string& art_dir);

// Makes a folder and those above it, unless they are there. Errors: INVALID_ARGUMENT it cannot be
// made.
absl::Status MakeFolder(const std::string& folder);

}  // namespace procgen

#endif  // TOOLS_ART_REQUESTS_H_
