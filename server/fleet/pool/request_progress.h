#ifndef SERVER_FLEET_POOL_REQUEST_PROGRESS_H_
#define SERVER_FLEET_POOL_REQUEST_PROGRESS_H_

#include <optional>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "envcore/pool/pool.h"
#include "server/session/backend/pool_backend.h"
#include "server/session/backend/request.h"

namespace procgen {

// Tracks the shards that execute the current request, and the part of it that waits for an answer.
// A part can be answered when all shards that it touches are done. The last part, and any part
// after an error, can be answered when all shards are done.
// Threads: any method from any thread; Begin while no request runs.
class RequestProgress {
 public:
  // A part that can be answered now.
  struct Answer {
    Part part;
    Batch batch;
    PoolBackend::Done done;
    absl::Status status;  // the first error of the request
  };

  // Begins a request of `slice`. No part can be answered before Start.
  void Begin(Part slice);
  // Sets the shards, by range, that execute the request; empty: it ends with `status`.
  void Start(std::vector<Part> ranges, absl::Status status = absl::OkStatus());
  // Adds the part that the learner waits for. Returns it if it can be answered now.
  std::optional<Answer> AddPart(Part part, const Batch& batch, PoolBackend::Done done);
  // Marks the shard of `range` as done. Returns the waiting part if it can be answered now.
  std::optional<Answer> OnShardDone(Part range, const absl::Status& status);

 private:
  std::optional<Answer> TakeAnswer() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  absl::Mutex mutex_;
  Part slice_ ABSL_GUARDED_BY(mutex_);
  bool has_started_ ABSL_GUARDED_BY(mutex_) = false;
  std::vector<Part> running_ ABSL_GUARDED_BY(mutex_);  // ranges of shards
  absl::Status status_ ABSL_GUARDED_BY(mutex_);        // the first error
  Part part_ ABSL_GUARDED_BY(mutex_);
  Batch batch_ ABSL_GUARDED_BY(mutex_);
  PoolBackend::Done done_ ABSL_GUARDED_BY(mutex_);  // null: no part waits
};

}  // namespace procgen

#endif  // SERVER_FLEET_POOL_REQUEST_PROGRESS_H_
