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

// The requests of a pool in order, back to the oldest checkpoint of a shard. Entries are numbered
// from 1 over the life of the pool.
// Threads: any method from any thread.
class RequestLog {
 public:
  using Entry = std::shared_ptr<const LoggedRequest>;  // shared with executing shards

  // The log of a new pool with stacks of `frame_stack` frames.
  explicit RequestLog(int32_t env_count = 0, int32_t frame_stack = 1)
      : warmup_(env_count, frame_stack) {}

  // Sets the number before the first entry; nothing is known of earlier ones. REQUIRES: no entry
  // was added.
  void BeginAfter(int64_t number);
  // Adds an entry and returns its number.
  int64_t Append(Entry entry);
  int64_t Append(LoggedRequest request) {
    return Append(std::make_shared<const LoggedRequest>(std::move(request)));
  }
  // Removes the last entry.
  void RemoveLast();
  // Drops the entries up to `number`.
  void ForgetUpTo(int64_t number);

  // REQUIRES: the entry was not dropped.
  Entry Find(int64_t number) const;
  // The number of the last entry.
  int64_t end() const;
  // Whether observations of `range` can be drawn from states saved after `number`.
  bool CanDrawFrom(Part range, int64_t number) const;
  // Approximate memory of the entries after `number`, in bytes.
  int64_t BytesAfter(int64_t number) const;

 private:
  mutable absl::Mutex mutex_;
  int64_t first_ ABSL_GUARDED_BY(mutex_) = 1;  // the number of the first entry
  FrameStackWarmup warmup_ ABSL_GUARDED_BY(mutex_);
  std::deque<Entry> entries_ ABSL_GUARDED_BY(mutex_);
  // Cumulative bytes of all entries ever added, up to each entry.
  std::deque<int64_t> byte_sums_ ABSL_GUARDED_BY(mutex_);
  int64_t forgotten_bytes_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace procgen

#endif  // SERVER_FLEET_LOG_REQUEST_LOG_H_
