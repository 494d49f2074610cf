#include "tests/benchmark/art_flag.h"

#include <cstdlib>
#include <iostream>
#include <string>
#include <utility>

#include "absl/flags/flag.h"

ABSL_FLAG(std::string, art_dir, "",
          "folder with art in the layout of Procgen 0.10.7; empty: the built-in art only");

namespace procgen {

std::shared_ptr<const SharedArt> ArtOfFlag() {
  const std::string folder = absl::GetFlag(FLAGS_art_dir);
  if (folder.empty()) {
    return nullptr;
  }
  auto art = SharedArt::LoadFolder(folder);
  if (!art.ok()) {
    std::cerr << "--art_dir: " << art.status().message() << "\n";
    std::exit(2);
  }
  return *std::move(art);
}

}  // namespace procgen
