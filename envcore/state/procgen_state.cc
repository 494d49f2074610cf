// procgen-state: prints a snapshot.
//
//   procgen-state dump FILE     prints the snapshot in FILE as JSON; -: standard input
//   procgen-state --help        prints the usage
//
// Exit status: 0; 1 if the file is not a snapshot; 2 if the usage is wrong or the file cannot be
// read.

#include <fstream>
#include <iostream>
#include <sstream>
#include <string>

#include "absl/strings/string_view.h"
#include "envcore/state/state_archive.h"
#include "envcore/status/status.h"

namespace {

constexpr int kNoSnapshot = 1;
constexpr int kBadUse = 2;

constexpr absl::string_view kUsage =
    "usage: procgen-state dump FILE\n"
    "Prints the snapshot in FILE (- is the standard input) as JSON.\n";

int Dump(const std::string& path) {
  std::ifstream file;
  if (path != "-") {
    file.open(path, std::ios::binary);
  }
  std::istream& input = path == "-" ? std::cin : file;
  std::ostringstream bytes;
  // A directory can be opened but not read. Reading no bytes would set the failbit of `bytes`.
  if (input && input.peek() != std::istream::traits_type::eof()) {
    bytes << input.rdbuf();
  }
  if (input.bad() || (!input && !input.eof())) {
    std::cerr << "procgen-state: cannot read " << path << "\n";
    return kBadUse;
  }
  const procgen::StatusOr<std::string> json = procgen::SnapshotAsJson(bytes.str());
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
  if (argument_count == 2 && absl::string_view(arguments[1]) == "--help") {
    std::cout << kUsage;
    return 0;
  }
  std::cerr << kUsage;
  return kBadUse;
}
