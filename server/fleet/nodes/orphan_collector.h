#ifndef SERVER_FLEET_NODES_ORPHAN_COLLECTOR_H_
#define SERVER_FLEET_NODES_ORPHAN_COLLECTOR_H_

#include <map>
#include <memory>
#include <set>
#include <string>
#include <thread>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "server/concurrency/steady_time.h"
#include "server/fleet/nodes/fleet_nodes.h"

namespace procgen {

// Deletes orphans: pools on the nodes that were shards of this fleet and no longer are. A shard
// leaves one when it moves, an earlier process of this fleet leaves its own, and a node that was
// cut off comes back with some. A node that cannot be reached frees them when their lease ends.
//
// The id of a pool begins with the fleet's name, so nothing else is deleted.
// Threads: any method from any thread; a thread of its own talks to the nodes.
class OrphanCollector {
 public:
  // `prefix`: what the ids of this fleet's pools begin with, and no others. `nodes` must outlive
  // this.
  OrphanCollector(std::string prefix, FleetNodes* nodes);
  // Deletes what it can at once.
  ~OrphanCollector();
  OrphanCollector(const OrphanCollector&) = delete;
  OrphanCollector& operator=(const OrphanCollector&) = delete;

  // A pool's id that begins with `prefix`, to be made on a node; it is in use from now on.
  void BeginUse(const std::string& pool_id);
  // It is not in use any more.
  void EndUse(const std::string& pool_id, const std::string& node_id);
  // Nodes may have come or gone. Connects to those that are new and deletes their orphans.
  void OnNodesChanged();

 private:
  void Run();
  // The nodes to delete orphans on: those that failed least often first, so that nodes that cannot
  // be reached do not delay others for long.
  std::vector<std::string> PendingNodes() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Deletes the pools of a node that begin with the prefix and are in no use; false: it could not
  // be asked.
  bool CollectFrom(const std::string& node_id);

  const std::string prefix_;
  FleetNodes* const nodes_;

  absl::Mutex mutex_;
  std::set<std::string> used_ ABSL_GUARDED_BY(mutex_);  // ids of pools
  // Nodes to delete orphans on, and how often that has failed.
  std::map<std::string, int32_t> pending_ ABSL_GUARDED_BY(mutex_);
  std::set<std::string> present_ ABSL_GUARDED_BY(mutex_);  // nodes, at the last poll
  bool changed_ ABSL_GUARDED_BY(mutex_) = true;
  bool stops_ ABSL_GUARDED_BY(mutex_) = false;
  SteadyCondVar wakes_;  // changed_ or stops_ is set
  std::thread thread_;
};

}  // namespace procgen

#endif  // SERVER_FLEET_NODES_ORPHAN_COLLECTOR_H_
