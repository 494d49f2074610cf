#ifndef TESTS_PROGRAM_RUN_H_
#define TESTS_PROGRAM_RUN_H_

#include <array>
#include <cstdio>
#include <string>

namespace procgen {

// The exit status of a program, and its merged output streams.
struct ProgramRun {
  int exit_status = -1;
  std::string output;
};

// Runs a shell command and waits for its end.
inline ProgramRun RunProgram(const std::string& command) {
  ProgramRun run;
  std::FILE* pipe = popen((command + " 2>&1").c_str(), "r");
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
