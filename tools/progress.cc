#include "tools/progress.h"

#include <unistd.h>

#include <algorithm>
#include <iostream>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace procgen {
namespace {

constexpr int64_t kBarLength = 24;
constexpr absl::string_view kLineStart = "\r\033[K";  // and clears the line

}  // namespace

Progress::Progress(size_t course_count)
    : course_count_(course_count), terminal_(isatty(STDERR_FILENO) != 0) {}

void Progress::Show(absl::string_view course, int64_t done, int64_t total) {
  if (!terminal_) {
    return;
  }
  std::string bar;
  for (int64_t i = 0; i < kBarLength; ++i) {
    bar += i < kBarLength * done / std::max<int64_t>(1, total) ? "█" : "░";
  }
  std::cerr << kLineStart << Line(course) << bar << " " << done << "/" << total << std::flush;
}

void Progress::Finish(absl::string_view course, absl::string_view outcome) {
  std::cerr << (terminal_ ? kLineStart : "") << Line(course) << outcome << std::endl;
  ++courses_done_;
}

std::string Progress::Line(absl::string_view course) const {
  return absl::StrFormat("[%2d/%d] %-16s ", courses_done_ + 1, course_count_, course);
}

}  // namespace procgen
