#ifndef SERVER_FLEET_LOG_REQUEST_LOG_H_
#define SERVER_FLEET_LOG_REQUEST_LOG_H_

#include <cstdint>
#include <deque>
#include <memory>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "server/fleet/log/frame_stack_warmup.h"
#include "server/fleet/log/logged_request.h"

namespace procgen {

// What was asked of a pool, in order, as far back as a shard may have to begin anew from. Numbers
// count from 1, in the life of the pool.
// Threads: any method from any thread.
class RequestLog {
 public:
  using Entry = std::shared_ptr<const LoggedRequest>;  // shared with who carries it out

  // Of a pool as it was made, with stacks of `frame_stack` frames.
  explicit RequestLog(int32_t env_count = 0, int32_t frame_stack = 1)
      : warmup_(env_count, frame_stack) {}

  // Has the first one bear the number after this, in a pool of which no more is known. REQUIRES:
  // none has been added.
  void BeginAfter(int64_t number);
  // Adds one and returns its number.
  int64_t Append(Entry entry);
  int64_t Append(LoggedRequest request) {
    return Append(std::make_shared<const LoggedRequest>(std::move(request)));
  }
  // Takes the last one back.
  void TakeBack();
  // Forgets those up to `number`.
  void ForgetUpTo(int64_t number);

  // REQUIRES: it has not been forgotten.
  Entry Find(int64_t number) const;
  // The number of the last one.
  int64_t end() const;
  // Whether observations of `range` can be drawn from states that were saved after `number`.
  bool CanDrawFrom(Part range, int64_t number) const;
  // About as much memory as those after `number` take.
  int64_t BytesAfter(int64_t number) const;

 private:
  mutable absl::Mutex mutex_;
  int64_t first_ ABSL_GUARDED_BY(mutex_) = 1;  // the number of the first entry
  FrameStackWarmup warmup_ ABSL_GUARDED_BY(mutex_);
  std::deque<Entry> entries_ ABSL_GUARDED_BY(mutex_);
  // Bytes of all that ever came, up to each entry.
  std::deque<int64_t> byte_sums_ ABSL_GUARDED_BY(mutex_);
  int64_t forgotten_bytes_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace procgen

#endif  // SERVER_FLEET_LOG_REQUEST_LOG_H_
