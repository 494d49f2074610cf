#include "procgen_client/internal/call_completions.h"

#include "grpc/support/time.h"

namespace procgen_client {

bool CallCompletions::Await(CallOperation operation) {
  absl::MutexLock lock(&mutex_);
  while (!IsOver(operation)) {
    if (is_polling_) {
      polled_.WaitWithTimeout(&mutex_, kCancellationInterval);
    } else {
      PollOnce();
    }
  }
  State& state = states_[static_cast<size_t>(operation)];
  const bool is_ok = state == State::kOk;
  state = State::kUnderWay;
  return is_ok;
}

void CallCompletions::PollOnce() {
  is_polling_ = true;
  mutex_.Unlock();
  const gpr_timespec deadline = gpr_time_add(
      gpr_now(GPR_CLOCK_MONOTONIC),
      gpr_time_from_millis(absl::ToInt64Milliseconds(kCancellationInterval), GPR_TIMESPAN));
  void* tag = nullptr;
  bool is_ok = false;
  const grpc::CompletionQueue::NextStatus status = queue_.AsyncNext(&tag, &is_ok, deadline);
  if (status == grpc::CompletionQueue::TIMEOUT && cancellation_->Check()) {
    context_->TryCancel();
  }
  mutex_.Lock();
  is_polling_ = false;
  if (status == grpc::CompletionQueue::GOT_EVENT) {
    states_[reinterpret_cast<uintptr_t>(tag)] = is_ok ? State::kOk : State::kFailed;
  }
  polled_.SignalAll();
}

void CallCompletions::Drain() {
  {
    absl::MutexLock lock(&mutex_);
    if (is_drained_) {
      return;
    }
    is_drained_ = true;
  }
  context_->TryCancel();
  queue_.Shutdown();
  void* tag = nullptr;
  bool is_ok = false;
  while (queue_.Next(&tag, &is_ok)) {
  }
}

}  // namespace procgen_client
