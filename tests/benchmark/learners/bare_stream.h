#ifndef TESTS_BENCHMARK_LEARNERS_BARE_STREAM_H_
#define TESTS_BENCHMARK_LEARNERS_BARE_STREAM_H_

#include <cstddef>
#include <memory>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace procgen {

// Sizes of requests and responses in bytes, and the maximum number of unanswered requests.
struct StreamShape {
  size_t request_bytes = 0;
  size_t response_bytes = 0;
  int requests_in_flight = 1;
};

// A gRPC stream over loopback TCP that carries the messages of RunPool and does nothing else: the
// reference for the throughput of gRPC. Both sides use generated code. The server reads no request
// and answers with three prepared messages in turn, because three batches circulate in a pool that
// is stepped while responses are in transit. The client returns parsed messages.
// Threads: compatible (one thread at a time).
class BareStream {
 public:
  // Starts the server on a free port and connects. Errors: UNAVAILABLE.
  static absl::StatusOr<std::unique_ptr<BareStream>> Start(const StreamShape& shape);
  virtual ~BareStream() = default;

  // Sends all but one of the requests that may be unanswered.
  virtual absl::Status SendAhead() = 0;
  // Sends a request and receives the response to the oldest. All three methods block and return
  // UNAVAILABLE if the stream breaks.
  virtual absl::Status Exchange() = 0;
  // Receives the responses to the requests of SendAhead.
  virtual absl::Status ReceiveRest() = 0;
};

}  // namespace procgen

#endif  // TESTS_BENCHMARK_LEARNERS_BARE_STREAM_H_
