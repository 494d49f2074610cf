#ifndef SERVER_FLEET_REQUEST_LOG_H_
#define SERVER_FLEET_REQUEST_LOG_H_

#include <cstdint>
#include <deque>
#include <memory>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "procgen/v1/states.pb.h"
#include "procgen/v1/step.pb.h"

namespace procgen {

// Something that was asked of a pool and may have changed it, in the numbers of the whole pool: a
// request of its stream, or states that were put into it.
struct LoggedRequest {
  v1::StepPoolRequest request;    // of none of the kinds: states
  std::vector<v1::State> states;  // none: a request
};

// What was asked of a pool, in order, as far back as a shard may have to begin anew from. Numbers
// count from 1, in the life of the pool.
// Threads: any method from any thread.
class RequestLog {
 public:
  using Entry = std::shared_ptr<const LoggedRequest>;  // shared with who carries it out

  // Has the first one bear the number after this. REQUIRES: none has been added.
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
  // What those after `number` take.
  int64_t BytesAfter(int64_t number) const;

 private:
  mutable absl::Mutex mutex_;
  int64_t first_ ABSL_GUARDED_BY(mutex_) = 1;  // the number of the first entry
  std::deque<Entry> entries_ ABSL_GUARDED_BY(mutex_);
  // Bytes of all that ever came, up to each entry.
  std::deque<int64_t> byte_sums_ ABSL_GUARDED_BY(mutex_);
  int64_t forgotten_bytes_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace procgen

#endif  // SERVER_FLEET_REQUEST_LOG_H_
