#ifndef TOOLS_PROGRESS_H_
#define TOOLS_PROGRESS_H_

#include <cstdint>
#include <string>

#include "absl/strings/string_view.h"

namespace procgen {

// Tells on the standard error stream how far tasks have come: on a terminal one line that is
// written anew, elsewhere a line for each task that is done. So the standard output stream holds
// results alone. Threads: compatible (one thread at a time).
class Progress {
 public:
  // `task_count` tasks follow.
  explicit Progress(size_t task_count);

  // `done` of `total` pieces of the running task are done.
  void Show(absl::string_view task, int64_t done, int64_t total);
  // The running task is done; `outcome` in a few words.
  void Finish(absl::string_view task, absl::string_view outcome);

 private:
  // "[ 3/16] maze easy".
  std::string Line(absl::string_view task) const;

  const size_t task_count_;
  const bool terminal_;
  size_t tasks_done_ = 0;
};

}  // namespace procgen

#endif  // TOOLS_PROGRESS_H_
