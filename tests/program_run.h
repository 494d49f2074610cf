#ifndef TESTS_PROGRAM_RUN_H_
#define TESTS_PROGRAM_RUN_H_

#include <array>
#include <cstdio>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"

namespace procgen {

// How a run of a program ended.
struct ProgramRun {
  int exit_status = -1;
  std::string output;  // standard output and error together
};

// Runs `program` with `arguments`, as a shell reads them, to its end.
inline ProgramRun RunProgram(absl::string_view program, absl::string_view arguments) {
  ProgramRun run;
  std::FILE* pipe = popen(absl::StrCat(program, " ", arguments, " 2>&1").c_str(), "r");
  std::array<char, 4096> buffer;
  while (std::fgets(buffer.data(), static_cast<int>(buffer.size()), pipe) != nullptr) {
    run.output += buffer.data();
  }
  const int status = pclose(pipe);
  run.exit_status = status >= 0 ? status >> 8 : status;
  return run;
}

}  // namespace procgen

#endif  // TESTS_PROGRAM_RUN_H_
