#ifndef TESTS_BENCHMARK_BARE_PIPES_H_
#define TESTS_BENCHMARK_BARE_PIPES_H_

#include <cstddef>
#include <memory>
#include <thread>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/shared_memory/file_descriptor.h"

namespace procgen {

// Two pipes and a thread that does nothing but wait for an answer, for which the kernel wakes it,
// and send the next request: what a learner that shares memory costs, and its messages, before
// anybody has looked at them.
// Threads: compatible (one thread at a time).
class BarePipes {
 public:
  // Of messages of these sizes, in bytes; one request is sent ahead. Errors: RESOURCE_EXHAUSTED no
  // file descriptors.
  static absl::StatusOr<std::unique_ptr<BarePipes>> Start(size_t request_bytes,
                                                          size_t answer_bytes);
  ~BarePipes();
  BarePipes(const BarePipes&) = delete;
  BarePipes& operator=(const BarePipes&) = delete;

  // Answers a request and receives the next, as a server does between two steps. Errors:
  // UNAVAILABLE.
  absl::Status Exchange();

 private:
  BarePipes(size_t request_bytes, size_t answer_bytes);

  // What the thread does.
  void Ask();

  std::vector<char> request_;
  std::vector<char> answer_;
  FileDescriptor requests_;           // read by the server
  FileDescriptor learners_requests_;  // written by the thread
  FileDescriptor learners_answers_;   // read by the thread
  FileDescriptor answers_;            // written by the server
  std::thread learner_;
};

}  // namespace procgen

#endif  // TESTS_BENCHMARK_BARE_PIPES_H_
