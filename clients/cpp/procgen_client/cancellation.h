#ifndef PROCGEN_CLIENT_CANCELLATION_H_
#define PROCGEN_CLIENT_CANCELLATION_H_

#include <functional>
#include <utility>

#include "absl/time/time.h"

namespace procgen_client {

// Returns whether the calling thread should stop waiting for the server.
using CancellationCheck = std::function<bool()>;

// How often a thread that waits calls the check. An interruption takes effect within this time.
inline constexpr absl::Duration kCancellationInterval = absl::Milliseconds(50);

// The cancellation of one call. Once the check has returned true it stays cancelled.
// Threads: compatible.
class Cancellation {
 public:
  // `check`: may be empty, never cancelled.
  explicit Cancellation(CancellationCheck check) : check_(std::move(check)) {}
  // Calls the check, unless it is cancelled already.
  bool Check() {
    if (!is_cancelled_ && check_ != nullptr && check_()) {
      is_cancelled_ = true;
    }
    return is_cancelled_;
  }
  // Sleeps for `duration`. False: cancelled before it was over.
  bool Sleep(absl::Duration duration);

 private:
  const CancellationCheck check_;
  bool is_cancelled_ = false;
};

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_CANCELLATION_H_
