#ifndef TOOLS_ART_REQUESTS_H_
#define TOOLS_ART_REQUESTS_H_

#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "envcore/games/game_catalog.h"
#include "envcore/pool/shared_art.h"

namespace procgen {

// What to draw, from the command line.
struct DrawingRequest {
  std::vector<const GameSpec*> games;
  std::shared_ptr<const SharedArt> art;
};

// Returns the games with these names, or all games if there are none, and the art to draw with.
// `art_dir`: a folder in the layout of Procgen 0.10.7; empty: the built-in art. Errors:
// INVALID_ARGUMENT: no game has the name (the message lists the games); for the folder as
// SharedArt::LoadFolder.
absl::StatusOr<DrawingRequest> MakeDrawingRequest(const std::vector<std::string>& game_names,
                                                  const std::string& art_dir);

}  // namespace procgen

#endif  // TOOLS_ART_REQUESTS_H_
