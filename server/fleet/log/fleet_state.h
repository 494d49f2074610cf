#ifndef SERVER_FLEET_LOG_FLEET_STATE_H_
#define SERVER_FLEET_LOG_FLEET_STATE_H_

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "server/fleet/log/journal.h"

namespace procgen {

// A folder where a fleet server keeps its pools, so that the next process goes on with them. One
// process at a time has it.
//
//     lock       held by the process that has it
//     name       of the fleet, in the names of its pools on the nodes
//     pool-7     the journal of a pool, and its write-ahead log, pool-7-wal
// Threads: any method from any thread.
class FleetState {
 public:
  // A pool that an earlier process left.
  struct Left {
    std::string path;
    JournaledPool pool;
  };

  // Makes the folder if there is none. Errors: FAILED_PRECONDITION another process has it;
  // UNAVAILABLE it cannot be read or written.
  static absl::StatusOr<std::shared_ptr<FleetState>> Open(const std::string& path);
  ~FleetState();
  FleetState(const FleetState&) = delete;
  FleetState& operator=(const FleetState&) = delete;

  const std::string& fleet_name() const { return fleet_name_; }
  // What earlier processes left. Those that are damaged are put aside, those of other versions of
  // the server stay where they are; both is logged.
  std::vector<Left> TakeLeft();
  // Where to keep another pool.
  std::string NextPath();

 private:
  FleetState(std::string path, int lock) : path_(std::move(path)), lock_(lock) {}
  absl::Status ReadName();

  const std::string path_;
  const int lock_;  // a file
  std::string fleet_name_;

  absl::Mutex mutex_;
  int64_t last_number_ ABSL_GUARDED_BY(mutex_) = 0;  // of all files of pools, also damaged ones
};

}  // namespace procgen

#endif  // SERVER_FLEET_LOG_FLEET_STATE_H_
