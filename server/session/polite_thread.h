#ifndef SERVER_SESSION_POLITE_THREAD_H_
#define SERVER_SESSION_POLITE_THREAD_H_

#include <atomic>
#include <cstdint>

#include "absl/functional/any_invocable.h"
#include "absl/time/time.h"
#include "server/session/side_crew.h"

namespace procgen {

// A thread for work that may be left out rather than slow anybody down: of the lowest priority, and
// where others want its core all the same, it tells when it should be given more.
//
// Priority alone is not enough: a thread that waits for work gives its core to whoever wants it,
// also to this one, and gets it back some milliseconds later.
// Threads: any method from any thread.
class PoliteThread {
 public:
  PoliteThread();
  PoliteThread(const PoliteThread&) = delete;
  PoliteThread& operator=(const PoliteThread&) = delete;

  // Hands work over and returns at once. Work begins in the order of handing over.
  void Run(absl::AnyInvocable<void()> work);
  // Until when it should rest, on SteadyNow's clock, so that it takes 1 in 200 of the machine. In
  // the past where nobody wanted its core while it last worked.
  absl::Time rests_until() const { return absl::FromUnixNanos(rests_until_ns_); }

  // How long it should rest after it has worked for so long, where others wanted its core.
  static absl::Duration RestAfter(absl::Duration work, int core_count);

 private:
  std::atomic<int64_t> rests_until_ns_ = 0;
  SideCrew crew_{1};  // last, so that it ends before what it uses
};

}  // namespace procgen

#endif  // SERVER_SESSION_POLITE_THREAD_H_
