#ifndef TESTS_BENCHMARK_VIEWER_PROCESS_H_
#define TESTS_BENCHMARK_VIEWER_PROCESS_H_

#include <sys/types.h>

#include <cstdint>
#include <cstdio>
#include <string>

#include "absl/status/statusor.h"

namespace procgen {

// The program procgen-benchmark-viewer, run. It ends with this.
// Threads: compatible (one thread at a time).
class ViewerProcess {
 public:
  // Watches the first pool of the server at `address` at this size.
  ViewerProcess(const std::string& address, int32_t size_px);
  ~ViewerProcess();
  ViewerProcess(const ViewerProcess&) = delete;
  ViewerProcess& operator=(const ViewerProcess&) = delete;

  // Has it begin to watch, and waits for the first moment; or has it end, and returns how many came
  // after that one. In turn. Errors: UNKNOWN it has ended, and told why on standard error.
  absl::StatusOr<int64_t> Toggle();

 private:
  pid_t process_ = -1;
  FILE* input_ = nullptr;
  FILE* output_ = nullptr;
};

}  // namespace procgen

#endif  // TESTS_BENCHMARK_VIEWER_PROCESS_H_
