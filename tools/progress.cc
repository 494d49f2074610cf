#include "tools/progress.h"

#include <unistd.h>

#include <algorithm>
#include <iostream>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace procgen {
namespace {

constexpr int64_t kBarLength = 24;
constexpr absl::string_view kLineStart = "\r\033[K";  // carriage return, clear line

}  // namespace

Progress::Progress(size_t task_count)
    : task_count_(task_count), terminal_(isatty(STDERR_FILENO) != 0) {}

void Progress::Show(absl::string_view task, int64_t done, int64_t total) {
  if (!terminal_) {
    return;
  }
  std::string bar;
  for (int64_t i = 0; i < kBarLength; ++i) {
    bar += i < kBarLength * done / std::max<int64_t>(1, total) ? "█" : "░";
  }
  std::cerr << kLineStart << Line(task) << bar << " " << done << "/" << total << std::flush;
}

void Progress::Finish(absl::string_view task, absl::string_view outcome) {
  std::cerr << (terminal_ ? kLineStart : "") << Line(task) << outcome << std::endl;
  ++tasks_done_;
}

std::string Progress::Line(absl::string_view task) const {
  return absl::StrFormat("[%2d/%d] %-16s ", tasks_done_ + 1, task_count_, task);
}

}  // namespace procgen
