#ifndef SERVER_CONCURRENCY_START_THREAD_H_
#define SERVER_CONCURRENCY_START_THREAD_H_

#include <thread>

#include "absl/functional/any_invocable.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace procgen {

// Starts a thread that calls `work` once. The caller joins it.
// Errors: RESOURCE_EXHAUSTED the thread limit is reached; `work` is destroyed without being called.
absl::StatusOr<std::thread> StartThread(absl::AnyInvocable<void()> work);

// Checks that `count` more threads can run at once, by starting and ending them. Errors:
// RESOURCE_EXHAUSTED they cannot.
absl::Status CheckThreadLimit(int count);

}  // namespace procgen

#endif  // SERVER_CONCURRENCY_START_THREAD_H_
