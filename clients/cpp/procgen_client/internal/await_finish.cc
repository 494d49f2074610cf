#include "procgen_client/internal/await_finish.h"

#include "absl/time/time.h"
#include "grpc/support/time.h"

namespace procgen_client {

void AwaitFinish(grpc::ClientContext* context, grpc::CompletionQueue* queue,
                 Cancellation* cancellation) {
  queue->Shutdown();
  void* tag = nullptr;
  bool is_ok = false;
  const gpr_timespec interval =
      gpr_time_from_millis(absl::ToInt64Milliseconds(kCancellationInterval), GPR_TIMESPAN);
  while (true) {
    const gpr_timespec deadline = gpr_time_add(gpr_now(GPR_CLOCK_MONOTONIC), interval);
    switch (queue->AsyncNext(&tag, &is_ok, deadline)) {
      case grpc::CompletionQueue::SHUTDOWN:
        return;  // after the completion
      case grpc::CompletionQueue::TIMEOUT:
        if (cancellation->Check()) {
          context->TryCancel();
        }
        break;
      case grpc::CompletionQueue::GOT_EVENT:
        break;
    }
  }
}

}  // namespace procgen_client
