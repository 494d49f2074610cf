#ifndef PROCGEN_CLIENT_INTERNAL_CALL_END_H_
#define PROCGEN_CLIENT_INTERNAL_CALL_END_H_

#include <atomic>
#include <memory>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "grpcpp/alarm.h"
#include "grpcpp/client_context.h"
#include "procgen_client/internal/timing.h"

namespace procgen_client {

// Cancels a call after a timeout, unless destroyed before. Uses the monotonic clock.
class CallTimer {
 public:
  // Infinite `timeout`: never.
  CallTimer(const std::shared_ptr<grpc::ClientContext>& context, absl::Duration timeout);
  // Whether the timeout has passed.
  bool is_due() const { return *is_due_; }

 private:
  const std::shared_ptr<std::atomic<bool>> is_due_ = std::make_shared<std::atomic<bool>>(false);
  grpc::Alarm alarm_;
};

// DATA_LOSS if `timer`, of kEndReportTimeout, is due.
absl::Status CheckLastResponse(const CallTimer& timer);

// Waits for the end of a stream of `Response` messages, and stores its status in `end`. To be
// called after Read returned false: the server has ended the stream, or a response could not be
// parsed. Errors: DATA_LOSS a response could not be parsed; the call is cancelled then.
template <typename Response, typename Stream>
absl::Status AwaitEnd(const std::shared_ptr<grpc::ClientContext>& context, Stream* stream,
                      grpc::Status* end) {
  const CallTimer timer(context, kEndReportTimeout);
  // gRPC reports the status only after all responses have been read.
  Response dropped;
  while (stream->Read(&dropped)) {
  }
  *end = stream->Finish();
  return CheckLastResponse(timer);
}

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_INTERNAL_CALL_END_H_
