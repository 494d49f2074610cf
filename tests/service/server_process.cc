#include "tests/service/server_process.h"

#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "absl/strings/match.h"
#include "absl/strings/strip.h"
#include "gtest/gtest.h"

namespace procgen {

ServerProcess::ServerProcess(const std::vector<std::string>& flags) {
  int ends[2];
  EXPECT_EQ(pipe(ends), 0);
  std::vector<char*> arguments = {const_cast<char*>(PROCGEN_SERVER_BINARY)};
  for (const std::string& flag : flags) {
    arguments.push_back(const_cast<char*>(flag.c_str()));
  }
  arguments.push_back(nullptr);
  process_ = fork();
  if (process_ == 0) {
    dup2(ends[1], STDOUT_FILENO);
    dup2(ends[1], STDERR_FILENO);
    close(ends[0]);
    close(ends[1]);
    execv(arguments[0], arguments.data());
    _exit(127);
  }
  close(ends[1]);
  output_ = fdopen(ends[0], "r");
}

ServerProcess::~ServerProcess() {
  if (process_ > 0) {
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
  }
  fclose(output_);
}

std::string ServerProcess::Address() {
  std::string line;
  while (ReadLine(&line)) {
    if (absl::StartsWith(line, "listening on ")) {
      return std::string(absl::StripPrefix(line, "listening on "));
    }
    beginning_ += line + "\n";
  }
  return "";
}

void ServerProcess::Signal(int signal) const { kill(process_, signal); }

int ServerProcess::Wait() {
  std::string line;
  while (ReadLine(&line)) {
    rest_ += line + "\n";
  }
  int status = 0;
  waitpid(process_, &status, 0);
  process_ = -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

bool ServerProcess::ReadLine(std::string* line) {
  line->clear();
  int letter = 0;
  while ((letter = fgetc(output_)) != EOF && letter != '\n') {
    line->push_back(static_cast<char>(letter));
  }
  return letter != EOF;
}

}  // namespace procgen
