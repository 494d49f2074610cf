// procgen-state: shows what a snapshot holds.
//
//   procgen-state dump FILE     prints the snapshot in FILE as JSON; FILE - is the standard input
//
// Exits with 0, with 1 where the file is no snapshot, with 2 where it cannot be read.

#include <fstream>
#include <iostream>
#include <iterator>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "envcore/state/state_archive.h"

namespace {

constexpr int kNoSnapshot = 1;
constexpr int kBadUse = 2;

int Dump(const std::string& path) {
  std::ifstream file;
  if (path != "-") {
    file.open(path, std::ios::binary);
  }
  std::istream& input = path == "-" ? std::cin : file;
  if (!input) {
    std::cerr << "procgen-state: cannot read " << path << "\n";
    return kBadUse;
  }
  const std::string bytes(std::istreambuf_iterator<char>(input), {});
  const absl::StatusOr<std::string> json = procgen::SnapshotAsJson(bytes);
  if (!json.ok()) {
    std::cerr << "procgen-state: " << json.status().message() << "\n";
    return kNoSnapshot;
  }
  std::cout << *json << "\n";
  return 0;
}

}  // namespace

int main(int argument_count, char** arguments) {
  if (argument_count == 3 && absl::string_view(arguments[1]) == "dump") {
    return Dump(arguments[2]);
  }
  std::cerr << "usage: procgen-state dump FILE\n";
  return kBadUse;
}
