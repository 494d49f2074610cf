#ifndef SERVER_RPC_NODE_REPORTER_H_
#define SERVER_RPC_NODE_REPORTER_H_

#include <cstdint>
#include <functional>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "server/cluster/cluster.h"
#include "server/cluster/node_status.h"
#include "server/concurrency/deadline_timer.h"

namespace procgen {

// Reports the status of this server to the cluster: at construction, every second, and by
// ReportNow.
// Threads: any method from any thread.
class NodeReporter {
 public:
  // The state of a server; status.steps_per_second is not set.
  struct Snapshot {
    NodeStatus status;
    int64_t step_count = 0;  // environment steps since the start
  };

  // Calls `take_snapshot`, which must not block for long, until destruction. `cluster` must outlive
  // this.
  NodeReporter(Cluster* cluster, std::function<Snapshot()> take_snapshot);

  // Reports the current status before it returns.
  void ReportNow();

 private:
  void Report(bool measures) ABSL_LOCKS_EXCLUDED(mutex_);

  Cluster* const cluster_;
  const std::function<Snapshot()> take_snapshot_;
  absl::Mutex mutex_;  // held during a report, which keeps reports in order
  int64_t measured_steps_ ABSL_GUARDED_BY(mutex_) = 0;
  absl::Time measured_at_ ABSL_GUARDED_BY(mutex_);
  double steps_per_second_ ABSL_GUARDED_BY(mutex_) = 0;
  DeadlineTimer timer_;  // last, because its thread uses all other members
};

}  // namespace procgen

#endif  // SERVER_RPC_NODE_REPORTER_H_
