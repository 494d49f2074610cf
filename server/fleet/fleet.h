#ifndef SERVER_FLEET_FLEET_H_
#define SERVER_FLEET_FLEET_H_

#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "server/concurrency/background_executor.h"
#include "server/concurrency/steady_time.h"
#include "server/fleet/nodes/fleet_nodes.h"
#include "server/fleet/nodes/fleet_options.h"
#include "server/fleet/nodes/orphan_collector.h"
#include "server/fleet/pool/fleet_pool.h"
#include "server/fleet/pool/shard_thread_budget.h"
#include "server/metrics/metrics.h"
#include "server/session/backend/pool_backend.h"

namespace procgen {

// Creates pools on the nodes of a cluster.
// Threads: any method from any thread. Its pools must be destroyed before it.
class Fleet final : public PoolBackendFactory {
 public:
  // `metrics` must outlive this.
  Fleet(FleetOptions options, Metrics* metrics);
  ~Fleet() override;
  Fleet(const Fleet&) = delete;
  Fleet& operator=(const Fleet&) = delete;

  // Errors: those of StateValidator::Create; UNAVAILABLE there is no node; RESOURCE_EXHAUSTED the
  // nodes have too little capacity, or no shard thread is available.
  void Create(const CreatePoolOptions& create_options, CreateDone done) override;
  std::vector<ResumedPool> TakeResumed() override;
  bool keeps_pools() const override { return options_.state != nullptr; }
  int32_t worker_count() const override { return nodes_.worker_count(); }

 private:
  // The placement of a new pool's shards, and the threads reserved for them.
  struct Plan {
    std::vector<ShardAssignment> assignments;
    std::vector<ShardThreadBudget::Reservation> threads;  // one each, or more
  };

  // Nodes may have changed. Does not block.
  void OnNodesChanged();
  absl::StatusOr<Plan> MakePlan(int32_t env_count);
  // Makes a pool without shards.
  absl::StatusOr<std::unique_ptr<FleetPool>> Make(const CreatePoolOptions& create_options);
  // Keeps the pool in a journal if there is a state directory.
  static absl::Status Keep(const CreatePoolOptions& create_options, const std::string& path,
                           FleetPool* pool);
  absl::StatusOr<ResumedPool> Resume(const FleetState::Left& left);
  // Calls OnNodesChanged of all pools when nodes have changed, and once per interval.
  void Watch();

  const FleetOptions options_;
  Metrics* const metrics_;
  const std::string name_;     // in the names of its pools on the nodes
  const std::string process_;  // identifies this process in those names
  FleetNodes nodes_;
  OrphanCollector orphan_collector_;
  ShardThreadBudget threads_;
  BackgroundExecutor executor_;

  absl::Mutex mutex_;
  std::set<FleetPool*> pools_ ABSL_GUARDED_BY(mutex_);
  int64_t pool_number_ ABSL_GUARDED_BY(mutex_) = 0;  // of the last pool made
  bool changed_ ABSL_GUARDED_BY(mutex_) = false;
  bool stops_ ABSL_GUARDED_BY(mutex_) = false;
  SteadyCondVar wakes_;  // changed_ or stops_ is set
  std::thread watch_;
  Subscription subscription_;  // last: its callback uses the members above
};

}  // namespace procgen

#endif  // SERVER_FLEET_FLEET_H_
