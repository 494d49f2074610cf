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

// The directory in which a fleet server keeps its pools for the next process. One process at a time
// uses it.
//
// lock       held by the process that uses it
// name       of the fleet, part of the names of its pools on the nodes
//     pool-7     the journal of a pool, and its write-ahead log, pool-7-wal
// Threads: any method from any thread.
class FleetState {
 public:
  // A pool of an earlier process.
  struct Left {
    std::string path;
    JournaledPool pool;
  };

  // Creates the directory if it does not exist. Errors: FAILED_PRECONDITION another process uses
  // it; UNAVAILABLE it cannot be read or written.
  static absl::StatusOr<std::shared_ptr<FleetState>> Open(const std::string& path);
  ~FleetState();
  FleetState(const FleetState&) = delete;
  FleetState& operator=(const FleetState&) = delete;

  const std::string& fleet_name() const { return fleet_name_; }
  // Reads the pools of earlier processes. Damaged ones are renamed, those of other server versions
  // stay as they are; both are logged.
  std::vector<Left> TakeLeft();
  // Returns the path for another pool.
  std::string NextPath();

 private:
  FleetState(std::string path, int lock) : path_(std::move(path)), lock_(lock) {}
  absl::Status ReadName();

  const std::string path_;
  const int lock_;  // file descriptor
  std::string fleet_name_;

  absl::Mutex mutex_;
  int64_t last_number_ ABSL_GUARDED_BY(mutex_) = 0;  // of all pool files, including damaged ones
};

}  // namespace procgen

#endif  // SERVER_FLEET_LOG_FLEET_STATE_H_
