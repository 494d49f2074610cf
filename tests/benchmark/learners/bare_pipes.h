#ifndef TESTS_BENCHMARK_LEARNERS_BARE_PIPES_H_
#define TESTS_BENCHMARK_LEARNERS_BARE_PIPES_H_

#include <cstddef>
#include <memory>
#include <thread>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/shared_memory/file_descriptor.h"

namespace procgen {

// Two pipes and a learner thread that waits for a response and sends the next request. It is the
// reference for the message cost of a learner in shared memory: nothing reads the messages.
// Threads: compatible (one thread at a time).
class BarePipes {
 public:
  // Starts the thread, with messages of these sizes in bytes and one request sent ahead. Errors:
  // RESOURCE_EXHAUSTED no file descriptors.
  static absl::StatusOr<std::unique_ptr<BarePipes>> Start(size_t request_bytes,
                                                          size_t answer_bytes);
  ~BarePipes();
  BarePipes(const BarePipes&) = delete;
  BarePipes& operator=(const BarePipes&) = delete;

  // Answers a request and receives the next, as a server does between two steps. Blocks. Errors:
  // UNAVAILABLE.
  absl::Status Exchange();

 private:
  BarePipes(size_t request_bytes, size_t answer_bytes);

  // Body of the learner thread.
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

#endif  // TESTS_BENCHMARK_LEARNERS_BARE_PIPES_H_
