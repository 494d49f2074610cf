#ifndef TESTS_BENCHMARK_BARE_STREAM_H_
#define TESTS_BENCHMARK_BARE_STREAM_H_

#include <cstddef>
#include <memory>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace procgen {

// What a stream sends: requests and responses of these sizes, in bytes, and how many requests may
// be unanswered.
struct StreamShape {
  size_t request_bytes = 0;
  size_t response_bytes = 0;
  int requests_in_flight = 1;
};

// A gRPC stream over loopback TCP that does nothing but send the messages of StepPool, as generated
// code has it on both sides: the server looks at no request and answers with messages that are
// ready (three in turn, as batches lie that are stepped while others are on their way), the client
// hands out parsed ones. What gRPC gives to who asks no more of it.
// Threads: compatible (one thread at a time).
class BareStream {
 public:
  // Starts the server on a free port and connects. Errors: UNAVAILABLE.
  static absl::StatusOr<std::unique_ptr<BareStream>> Start(const StreamShape& shape);
  virtual ~BareStream() = default;

  // Sends the requests that are sent ahead, all but one of those that may be unanswered.
  virtual absl::Status SendAhead() = 0;
  // Sends a request and receives the answer to the oldest. Errors, of all three: UNAVAILABLE.
  virtual absl::Status Exchange() = 0;
  // Receives the answers to those that were sent ahead.
  virtual absl::Status ReceiveRest() = 0;
};

}  // namespace procgen

#endif  // TESTS_BENCHMARK_BARE_STREAM_H_
