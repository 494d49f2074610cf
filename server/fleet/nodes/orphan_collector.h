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

// Deletes orphans: pools on nodes that were shards of this fleet and no longer are. They remain
// after a shard has moved, after a restart of the fleet server, and on nodes that return after a
// partition. On an unreachable node they expire with their lease.
//
// Pool ids begin with the fleet's name, so no other pools are deleted.
// Threads: any method from any thread; a thread of its own talks to the nodes.
class OrphanCollector {
 public:
  // `prefix`: of the ids of this fleet's pools, and no others. `nodes` must outlive this.
  OrphanCollector(std::string prefix, FleetNodes* nodes);
  // Deletes the orphans that it can delete without waiting.
  ~OrphanCollector();
  OrphanCollector(const OrphanCollector&) = delete;
  OrphanCollector& operator=(const OrphanCollector&) = delete;

  // Marks a pool id, which begins with `prefix`, as used before the pool is created.
  void BeginUse(const std::string& pool_id);
  // Marks it as unused.
  void EndUse(const std::string& pool_id, const std::string& node_id);
  // Handles changed nodes: connects to new ones and deletes their orphans.
  void OnNodesChanged();

 private:
  void Run();
  // The nodes to delete orphans on, those with the fewest failures first, so that unreachable nodes
  // do not delay others for long.
  std::vector<std::string> PendingNodes() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Deletes the unused pools of a node that begin with the prefix. Returns false if the node could
  // not be reached.
  bool CollectFrom(const std::string& node_id);

  const std::string prefix_;
  FleetNodes* const nodes_;

  absl::Mutex mutex_;
  std::set<std::string> used_ ABSL_GUARDED_BY(mutex_);  // ids of pools
  // Nodes to delete orphans on, with their number of failures.
  std::map<std::string, int32_t> pending_ ABSL_GUARDED_BY(mutex_);
  std::set<std::string> present_ ABSL_GUARDED_BY(mutex_);  // nodes at the last poll
  bool changed_ ABSL_GUARDED_BY(mutex_) = true;
  bool stops_ ABSL_GUARDED_BY(mutex_) = false;
  SteadyCondVar wakes_;  // changed_ or stops_ is set
  std::thread thread_;
};

}  // namespace procgen

#endif  // SERVER_FLEET_NODES_ORPHAN_COLLECTOR_H_
