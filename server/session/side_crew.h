#ifndef SERVER_SESSION_SIDE_CREW_H_
#define SERVER_SESSION_SIDE_CREW_H_

#include <cstdint>
#include <deque>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/functional/any_invocable.h"
#include "absl/synchronization/mutex.h"

namespace procgen {

// A few threads for work that takes long and is no step: making and freeing pools, looking at
// environments. So no reaction of the transport blocks, and no worker of the Crew is kept from
// stepping.
// Threads: any method from any thread, also from the work itself.
class SideCrew {
 public:
  // `thread_count` >= 1.
  explicit SideCrew(int32_t thread_count);
  // Carries out all work that was handed over, then ends the threads.
  ~SideCrew();
  SideCrew(const SideCrew&) = delete;
  SideCrew& operator=(const SideCrew&) = delete;

  // Hands work over and returns at once. Work begins in the order of handing over.
  void Run(absl::AnyInvocable<void()> work);

 private:
  bool HasWorkOrStops() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return stops_ || !work_.empty();
  }
  void WorkUntilStopped();

  absl::Mutex mutex_;
  std::deque<absl::AnyInvocable<void()>> work_ ABSL_GUARDED_BY(mutex_);
  bool stops_ ABSL_GUARDED_BY(mutex_) = false;
  std::vector<std::thread> threads_;
};

}  // namespace procgen

#endif  // SERVER_SESSION_SIDE_CREW_H_
