#ifndef PROCGEN_CLIENT_INTERNAL_CALL_COMPLETIONS_H_
#define PROCGEN_CLIENT_INTERNAL_CALL_COMPLETIONS_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "grpcpp/client_context.h"
#include "grpcpp/completion_queue.h"
#include "procgen_client/cancellation.h"

namespace procgen_client {

// The operations of a call, each of which is in progress at most once at a time.
enum class CallOperation : uint8_t { kStart, kRead, kWrite, kWritesDone, kFinish };
inline constexpr size_t kCallOperationCount = 5;

// The completion queue of one call. Threads that begin operations wait for them here, in turns of
// kCancellationInterval: gRPC's synchronous API cannot be interrupted.
// Threads: one may wait for each operation.
class CallCompletions {
 public:
  // `context`: of the call, which is cancelled once `cancellation` is. Both must outlive this.
  CallCompletions(grpc::ClientContext* context, Cancellation* cancellation)
      : context_(context), cancellation_(cancellation) {}
  ~CallCompletions() { Drain(); }
  CallCompletions(const CallCompletions&) = delete;
  CallCompletions& operator=(const CallCompletions&) = delete;

  grpc::CompletionQueue* queue() { return &queue_; }
  // The tag of an operation.
  static void* TagOf(CallOperation operation) {
    // NOLINTNEXTLINE(performance-no-int-to-ptr): never dereferenced
    return reinterpret_cast<void*>(static_cast<uintptr_t>(operation));
  }
  // Waits for an operation that was started. Returns gRPC's `ok` of its completion.
  bool Await(CallOperation operation);
  // Cancels the call and waits for the operations in progress. No operation may be started
  // afterwards.
  void Drain();

 private:
  enum class State : uint8_t { kUnderWay, kOk, kFailed };
  // Waits for the next completion of any operation, one interval at most.
  void PollOnce() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool IsOver(CallOperation operation) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return states_[static_cast<size_t>(operation)] != State::kUnderWay;
  }

  grpc::ClientContext* const context_;
  Cancellation* const cancellation_;
  grpc::CompletionQueue queue_;
  absl::Mutex mutex_;
  absl::CondVar polled_;
  bool is_polling_ ABSL_GUARDED_BY(mutex_) = false;  // some thread is, for all
  bool is_drained_ ABSL_GUARDED_BY(mutex_) = false;
  std::array<State, kCallOperationCount> states_ ABSL_GUARDED_BY(mutex_) = {};
};

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_INTERNAL_CALL_COMPLETIONS_H_
