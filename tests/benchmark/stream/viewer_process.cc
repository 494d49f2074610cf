#include "tests/benchmark/stream/viewer_process.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cinttypes>
#include <csignal>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"

namespace procgen {

ViewerProcess::ViewerProcess(const std::string& address, int32_t size_px) {
  std::array<int, 2> input = {};
  std::array<int, 2> output = {};
  if (pipe2(input.data(), O_CLOEXEC) != 0 || pipe2(output.data(), O_CLOEXEC) != 0) {
    return;
  }
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, input[0], STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, output[1], STDOUT_FILENO);
  std::string program = PROCGEN_BENCHMARK_VIEWER;
  std::string server = address;
  std::string side = absl::StrCat(size_px);
  std::array<char*, 4> arguments = {program.data(), server.data(), side.data(), nullptr};
  if (posix_spawn(&process_, program.c_str(), &actions, nullptr, arguments.data(), environ) != 0) {
    process_ = -1;
  }
  posix_spawn_file_actions_destroy(&actions);
  close(input[0]);
  close(output[1]);
  input_ = fdopen(input[1], "w");
  output_ = fdopen(output[0], "r");
}

ViewerProcess::~ViewerProcess() {
  if (process_ > 0) {
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
  }
  for (FILE* stream : {input_, output_}) {
    if (stream != nullptr) {
      fclose(stream);
    }
  }
}

absl::StatusOr<int64_t> ViewerProcess::Toggle() {
  int64_t frame_set_count = 0;
  if (process_ < 0 || fputs("\n", input_) == EOF || fflush(input_) != 0 ||
      fscanf(output_, "%" SCNd64, &frame_set_count) != 1) {
    return absl::UnknownError("procgen-benchmark-viewer has ended");
  }
  return frame_set_count;
}

}  // namespace procgen
