#ifndef TESTS_PICTURES_REQUESTS_H_
#define TESTS_PICTURES_REQUESTS_H_

#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "envcore/games/game_catalog.h"
#include "envcore/pool/shared_art.h"

namespace procgen {

// The games of these names; all if there are none. Errors: INVALID_ARGUMENT a name that no game has
// (the message says which there are).
absl::StatusOr<std::vector<const GameFacts*>> FindGames(const std::vector<std::string>& names);

// The art of a folder in the released layout; the built-in one if `folder` is empty. Errors: as
// SharedArt::LoadFolder.
absl::StatusOr<std::shared_ptr<const SharedArt>> OpenArt(const std::string& folder);

// Makes a folder and those above it, unless they are there. Errors: INVALID_ARGUMENT it cannot be
// made.
absl::Status MakeFolder(const std::string& folder);

}  // namespace procgen

#endif  // TESTS_PICTURES_REQUESTS_H_
