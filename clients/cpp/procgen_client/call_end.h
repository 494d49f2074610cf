#ifndef PROCGEN_CLIENT_CALL_END_H_
#define PROCGEN_CLIENT_CALL_END_H_

#include <atomic>
#include <memory>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "grpcpp/alarm.h"
#include "grpcpp/client_context.h"
#include "procgen_client/timing.h"

namespace procgen_client {

// Cancels a call when time is up, until this ends. Machines whose clock is set change nothing.
class CallTimer {
 public:
  CallTimer(const std::shared_ptr<grpc::ClientContext>& context, absl::Duration timeout);
  bool is_due() const { return *is_due_; }

 private:
  const std::shared_ptr<std::atomic<bool>> is_due_ = std::make_shared<std::atomic<bool>>(false);
  grpc::Alarm alarm_;
};

// DEADLINE_EXCEEDED if `timer`, of kEndTimeout, is due.
absl::Status CheckEndInTime(const CallTimer& timer);

// Waits until the server has ended a call whose responses are `Response`, and says how. For streams
// whose Read returned false: either the server has ended the stream, or a response was no message.
// Errors: DEADLINE_EXCEEDED it does not within 10 s; it is cancelled then.
template <typename Response, typename Stream>
absl::Status AwaitEnd(const std::shared_ptr<grpc::ClientContext>& context, Stream* stream,
                      grpc::Status* end) {
  const CallTimer timer(context, kEndTimeout);
  // gRPC tells the end to who has read all.
  Response dropped;
  while (stream->Read(&dropped)) {
  }
  *end = stream->Finish();
  return CheckEndInTime(timer);
}

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_CALL_END_H_
