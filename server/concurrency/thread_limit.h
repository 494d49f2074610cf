#ifndef SERVER_CONCURRENCY_THREAD_LIMIT_H_
#define SERVER_CONCURRENCY_THREAD_LIMIT_H_

#include "absl/status/status.h"

namespace procgen {

// Checks that `count` more threads can run at once, by starting and ending them. Errors:
// RESOURCE_EXHAUSTED they cannot.
absl::Status CheckThreadLimit(int count);

}  // namespace procgen

#endif  // SERVER_CONCURRENCY_THREAD_LIMIT_H_
