#ifndef TOOLS_PROGRESS_H_
#define TOOLS_PROGRESS_H_

#include <cstdint>
#include <string>

#include "absl/strings/string_view.h"

namespace procgen {

// Reports the progress of tasks on standard error: one updated line on a terminal, otherwise one
// line per finished task. Standard output contains results only. Threads: compatible (one thread at
// a time).
class Progress {
 public:
  // `task_count`: number of tasks.
  explicit Progress(size_t task_count);

  // Shows that `done` of `total` parts of the running task are done.
  void Show(absl::string_view task, int64_t done, int64_t total);
  // Ends the running task. `outcome`: a few words.
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
