#ifndef TOOLS_PROGRESS_H_
#define TOOLS_PROGRESS_H_

#include <cstdint>
#include <string>

#include "absl/strings/string_view.h"

namespace procgen {

// Tells on the standard error stream how far courses have come: on a terminal one line that is
// written anew, elsewhere a line for each course that is done. So the standard output stream holds
// results alone. Threads: compatible (one thread at a time).
class Progress {
 public:
  // `course_count` courses follow.
  explicit Progress(size_t course_count);

  // `done` of `total` pieces of the running course are done.
  void Show(absl::string_view course, int64_t done, int64_t total);
  // The running course is done; `outcome` in a few words.
  void Finish(absl::string_view course, absl::string_view outcome);

 private:
  // "[ 3/16] maze easy".
  std::string Line(absl::string_view course) const;

  const size_t course_count_;
  const bool terminal_;
  size_t courses_done_ = 0;
};

}  // namespace procgen

#endif  // TOOLS_PROGRESS_H_
