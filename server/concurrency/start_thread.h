#ifndef SERVER_CONCURRENCY_START_THREAD_H_
#define SERVER_CONCURRENCY_START_THREAD_H_

#include <thread>

#include "absl/functional/any_invocable.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace procgen {

// Starts a thread that calls `work` once. The caller joins it.
// Errors: RESOURCE_EXHAUSTED the process may have no more threads; `work` is destroyed uncalled.
absl::StatusOr<std::thread> StartThread(absl::AnyInvocable<void()> work);

// Whether `count` more threads can run at one time now: starts them, and ends them again.
// Errors: RESOURCE_EXHAUSTED the process may have fewer.
absl::Status CheckThreadLimit(int count);

}  // namespace procgen

#endif  // SERVER_CONCURRENCY_START_THREAD_H_
