#ifndef TESTS_BENCHMARK_STREAM_VIEWER_PROCESS_H_
#define TESTS_BENCHMARK_STREAM_VIEWER_PROCESS_H_

#include <sys/types.h>

#include <cstdint>
#include <cstdio>
#include <string>

#include "absl/status/statusor.h"

namespace procgen {

// A running procgen-benchmark-viewer, which the destructor ends.
// Threads: compatible (one thread at a time).
class ViewerProcess {
 public:
  // Starts it for the first pool of the server at `address`, with frames of this size.
  ViewerProcess(const std::string& address, int32_t size_px);
  ~ViewerProcess();
  ViewerProcess(const ViewerProcess&) = delete;
  ViewerProcess& operator=(const ViewerProcess&) = delete;

  // Alternately starts a subscription and waits for its first frame set, or ends it and returns the
  // number of frame sets after the first. Blocks. Errors: UNKNOWN the process has ended, with a
  // message on standard error.
  absl::StatusOr<int64_t> Toggle();

 private:
  pid_t process_ = -1;
  FILE* input_ = nullptr;
  FILE* output_ = nullptr;
};

}  // namespace procgen

#endif  // TESTS_BENCHMARK_STREAM_VIEWER_PROCESS_H_
