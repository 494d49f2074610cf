// procgen-state: prints a snapshot as JSON (readable_state.h), and the reverse.
//
//   procgen-state dump FILE     prints the snapshot in FILE as JSON; -: standard input
//   procgen-state encode FILE   writes the snapshot of the JSON in FILE to the standard output
//   procgen-state --help        prints the usage
//
// Exit status: 0; 1 if the file is not a snapshot, or not the JSON of one; 2 if the usage is wrong
// or the file cannot be read.

#include <fstream>
#include <iostream>
#include <sstream>
#include <string>

#include "absl/strings/string_view.h"
#include "envcore/environment/readable_state.h"
#include "envcore/status/status.h"

namespace {

constexpr int kNoSnapshot = 1;
constexpr int kBadUse = 2;

constexpr absl::string_view kUsage =
    "usage: procgen-state dump FILE\n"
    "       procgen-state encode FILE\n"
    "dump prints the snapshot in FILE (- is the standard input) as JSON. encode writes the "
    "snapshot "
    "of such JSON to the standard output.\n";

using Conversion = procgen::StatusOr<std::string> (*)(absl::string_view content);

int Convert(const std::string& path, Conversion conversion, absl::string_view end) {
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
  const procgen::StatusOr<std::string> converted = conversion(bytes.str());
  if (!converted.ok()) {
    std::cerr << "procgen-state: " << converted.status().message() << "\n";
    return kNoSnapshot;
  }
  std::cout << *converted << end;
  return 0;
}

}  // namespace

int main(int argument_count, char** arguments) {
  if (argument_count == 3 && absl::string_view(arguments[1]) == "dump") {
    return Convert(arguments[2], procgen::SnapshotToJson, "\n");
  }
  if (argument_count == 3 && absl::string_view(arguments[1]) == "encode") {
    return Convert(arguments[2], procgen::SnapshotFromJson, "");
  }
  if (argument_count == 2 && absl::string_view(arguments[1]) == "--help") {
    std::cout << kUsage;
    return 0;
  }
  std::cerr << kUsage;
  return kBadUse;
}
