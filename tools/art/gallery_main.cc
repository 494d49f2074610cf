// procgen-gallery: contact sheets of the games, in the agent's and the human view, and of their
// sprites. Writes single images and a list of sheets, then executes deploy/mosaic.py, which draws
// the sheets. See README.md.

#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <string>
#include <system_error>
#include <vector>

#include "absl/flags/flag.h"
#include "absl/flags/parse.h"
#include "absl/flags/usage.h"
#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "envcore/games/game_catalog.h"
#include "tools/art/gallery.h"
#include "tools/art/requests.h"

ABSL_FLAG(std::vector<std::string>, games, {}, "games to draw, e.g. maze,heist; empty: all");
ABSL_FLAG(std::string, art_dir, "",
          "folder with art in the layout of Procgen 0.10.7; empty: the built-in art");

namespace procgen {
namespace {

int Fail(absl::string_view error) {
  std::cerr << "procgen-gallery: " << error << "\n";
  return 2;
}

int Main(const std::vector<char*>& arguments) {
  if (arguments.size() != 2) {
    return Fail(absl::StrCat("expected 1 argument, the output folder, got ", arguments.size() - 1));
  }
  const std::string folder = arguments[1];
  const auto request = MakeDrawingRequest(absl::GetFlag(FLAGS_games), absl::GetFlag(FLAGS_art_dir));
  if (!request.ok()) {
    return Fail(request.status().message());
  }
  const std::string pictures = absl::StrCat(folder, "/pictures");
  std::error_code error;
  if (std::filesystem::create_directories(pictures, error); error) {
    return Fail(absl::StrCat("cannot create the folder '", pictures, "': ", error.message()));
  }
  Gallery gallery(folder, *request->art);
  size_t drawn = 0;
  for (const GameSpec* game : request->games) {
    if (absl::Status status = gallery.AddGame(*game); !status.ok()) {
      return Fail(status.message());
    }
    std::cerr << absl::StrFormat("[%2d/%d] %s\n", ++drawn, request->games.size(), game->name);
  }
  if (absl::Status status = gallery.AddSharedSprites(*request->games.front()); !status.ok()) {
    return Fail(status.message());
  }
  const std::string list = absl::StrCat(folder, "/sheets.json");
  if (!(std::ofstream(list) << gallery.SheetList() << std::flush)) {
    return Fail(absl::StrCat("cannot write ", list));
  }
  execl(PROCGEN_PYTHON, PROCGEN_PYTHON, PROCGEN_MOSAIC, list.c_str(), nullptr);
  return Fail(absl::StrCat("cannot run ", PROCGEN_PYTHON, ": ", std::strerror(errno)));
}

}  // namespace
}  // namespace procgen

int main(int argc, char** argv) {
  absl::SetProgramUsageMessage(
      "Draws contact sheets of the games and of their sprites into a folder.\n"
      "usage: procgen-gallery OUT_FOLDER [--games NAME,...] [--art_dir FOLDER]");
  return procgen::Main(absl::ParseCommandLine(argc, argv));
}
