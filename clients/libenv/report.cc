#include "clients/libenv/report.h"

#include <cstdio>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"

namespace procgen {

void Report(absl::string_view message) {
  const std::string line =
      absl::StrCat("libenv: ", absl::StrReplaceAll(message, {{"\n", " "}}), "\n");
  std::fwrite(line.data(), 1, line.size(), stderr);
  std::fflush(stderr);
}

}  // namespace procgen
