#ifndef SERVER_FLEET_NODES_LEFTOVERS_H_
#define SERVER_FLEET_NODES_LEFTOVERS_H_

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

// Which pools on the nodes are shards of this fleet, and the deletion of those that no longer are:
// what a shard left behind when it moved, what an earlier process of this fleet had, and what comes
// back with a node that was cut off. Nodes that cannot be reached free them when their lease ends.
//
// A pool's name bears the fleet's, so that nothing else is deleted.
// Threads: any method from any thread; nodes are talked to on one of its own.
class Leftovers {
 public:
  // `prefix`: what the ids of this fleet's pools begin with, and no others. `nodes` must outlive
  // this.
  Leftovers(std::string prefix, FleetNodes* nodes);
  // Deletes what it can at once.
  ~Leftovers();
  Leftovers(const Leftovers&) = delete;
  Leftovers& operator=(const Leftovers&) = delete;

  // A pool's id that begins with `prefix`, to be made on a node; it is in use from now on.
  void BeginUse(const std::string& pool_id);
  // It is not in use any more.
  void EndUse(const std::string& pool_id, const std::string& node_id);
  // Nodes may have come, or gone: who is new is connected to and looked through.
  void OnChange();

 private:
  void Run();
  // What to look through now: nodes that failed least often first, so that those that nobody can
  // reach keep nobody waiting for long.
  std::vector<std::string> Todo() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Deletes the pools of a node that begin with the prefix and are in no use; false: it could not
  // be asked.
  bool Clean(const std::string& node_id);

  const std::string prefix_;
  FleetNodes* const nodes_;

  absl::Mutex mutex_;
  std::set<std::string> used_ ABSL_GUARDED_BY(mutex_);  // ids of pools
  // Nodes to be looked through, and how often that has failed.
  std::map<std::string, int32_t> unclean_ ABSL_GUARDED_BY(mutex_);
  std::set<std::string> present_ ABSL_GUARDED_BY(mutex_);  // nodes, when it last looked
  bool changed_ ABSL_GUARDED_BY(mutex_) = true;
  bool stops_ ABSL_GUARDED_BY(mutex_) = false;
  SteadyCondVar wakes_;  // changed_ or stops_ is set
  std::thread thread_;
};

}  // namespace procgen

#endif  // SERVER_FLEET_NODES_LEFTOVERS_H_
