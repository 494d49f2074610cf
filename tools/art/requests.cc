#include "tools/art/requests.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"

namespace procgen {
namespace {

absl::StatusOr<std::vector<const GameSpec*>> FindGames(const std::vector<std::string>& names) {
  std::vector<const GameSpec*> games;
  for (const GameSpec& game : GameCatalog()) {
    if (names.empty()) {
      games.push_back(&game);
    }
  }
  for (const std::string& name : names) {
    const GameSpec* game = FindGame(name);
    if (game == nullptr) {
      return absl::InvalidArgumentError(absl::StrCat(
          "game '", name, "' is not one of ",
          absl::StrJoin(GameCatalog(), ", ", [](std::string* out, const GameSpec& known) {
            absl::StrAppend(out, known.name);
          })));
    }
    games.push_back(game);
  }
  return games;
}

absl::StatusOr<std::shared_ptr<const SharedArt>> OpenArt(const std::string& folder) {
  if (folder.empty()) {
    return SharedArt::Embedded();
  }
  return SharedArt::LoadFolder(folder);
}

}  // namespace

absl::StatusOr<DrawingRequest> MakeDrawingRequest(const std::vector<std::string>& game_names,
                                                  const std::string& art_dir) {
  auto games = FindGames(game_names);
  if (!games.ok()) {
    return games.status();
  }
  auto art = OpenArt(art_dir);
  if (!art.ok()) {
    return art.status();
  }
  return DrawingRequest{.games = *std::move(games), .art = *std::move(art)};
}

}  // namespace procgen
