#include "procgen_client/internal/call_end.h"

#include "grpc/support/time.h"

namespace procgen_client {

CallTimer::CallTimer(const std::shared_ptr<grpc::ClientContext>& context, absl::Duration timeout) {
  if (timeout == absl::InfiniteDuration()) {
    return;
  }
  const gpr_timespec time =
      gpr_time_add(gpr_now(GPR_CLOCK_MONOTONIC),
                   gpr_time_from_millis(absl::ToInt64Milliseconds(timeout), GPR_TIMESPAN));
  // Weak, so that a thread of gRPC never frees what the context owns (a stream and its channel).
  alarm_.Set(time, [weak = std::weak_ptr(context), is_due = is_due_](bool rings) {
    if (!rings) {
      return;
    }
    *is_due = true;
    if (const std::shared_ptr<grpc::ClientContext> call = weak.lock(); call != nullptr) {
      call->TryCancel();
    }
  });
}

absl::Status CheckLastResponse(const CallTimer& timer) {
  return timer.is_due() ? absl::DataLossError("a response of the server is malformed")
                        : absl::OkStatus();
}

}  // namespace procgen_client
