#ifndef TESTS_BENCHMARK_BARE_STREAM_H_
#define TESTS_BENCHMARK_BARE_STREAM_H_

#include <cstddef>
#include <memory>

#include "absl/status/statusor.h"
#include "absl/time/time.h"

namespace procgen {

// What a stream sends: requests and responses of these sizes, in bytes, and how many requests may
// be unanswered.
struct StreamShape {
  size_t request_bytes = 0;
  size_t response_bytes = 0;
  int requests_in_flight = 1;
};

// A gRPC stream over loopback TCP, server and client, that does nothing but send: no message is
// parsed, filled or copied by us. The most that any server behind gRPC can reach here.
// Threads: compatible (one thread at a time).
class BareStream {
 public:
  // Starts the server on a free port and connects. Errors: UNAVAILABLE.
  static absl::StatusOr<std::unique_ptr<BareStream>> Start(const StreamShape& shape);
  virtual ~BareStream() = default;

  // Exchanges requests and responses for about 0.1 s. Returns the mean time of one exchange, or an
  // infinite one if the stream broke.
  virtual absl::Duration MeasureExchange() = 0;
};

}  // namespace procgen

#endif  // TESTS_BENCHMARK_BARE_STREAM_H_
