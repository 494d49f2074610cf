#ifndef PROCGEN_CLIENT_RUN_RUN_STREAM_H_
#define PROCGEN_CLIENT_RUN_RUN_STREAM_H_

#include <functional>
#include <memory>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "grpcpp/support/byte_buffer.h"
#include "procgen/v1/run.pb.h"

namespace procgen_client {

// One call of RunPool, over gRPC or a simulated network. Nothing blocks but Next.
// Threads: one at a time; Cancel from any thread.
class RunStream {
 public:
  enum class Event {
    kNone,      // the time is over
    kWritten,   // the request was handed to the network
    kResponse,  // a response has arrived: response()
    kEnd,       // the call is over: status(); no other event follows
  };

  virtual ~RunStream() = default;

  // Begins to send a request. REQUIRES: the one before was written; the call is not over.
  virtual void Write(const procgen::v1::RunPoolRequest& request) = 0;
  // Announces that no request follows; the server then ends the call. REQUIRES: as Write.
  virtual void HalfClose() = 0;
  // Waits for the next event.
  virtual Event Next(absl::Duration timeout) = 0;
  // The serialised response of the last kResponse; may be moved from.
  virtual grpc::ByteBuffer& response() = 0;
  // Why the call is over. Never OK.
  virtual const absl::Status& status() const = 0;
  // Whether another call may succeed: the connection broke, or the server drains.
  virtual bool is_lost() const = 0;
  // Ends the call soon.
  virtual void Cancel() = 0;
};

// Begins another call. `attempt`: number of calls that failed since the last one that created its
// pool.
using OpenRunStream = std::function<std::unique_ptr<RunStream>(int attempt)>;

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_RUN_RUN_STREAM_H_
